"""The verdicts of a diagnosis: word, meaning, sentence, and whether the gap counts as explained."""

from __future__ import annotations

from enum import StrEnum


class Verdict(StrEnum):
    """A verdict, a word with its general `meaning` and the template of a `sentence` for one case.

    explained : whether every gap has a cause; then `magbench diagnose` exits with status 0, else with 1.
    """

    meaning: str
    template: str
    explained: bool

    def __new__(cls, word: str, meaning: str, template: str, explained: bool) -> Verdict:
        """Create a verdict from its word."""
        verdict = str.__new__(cls, word)
        verdict._value_ = word
        verdict.meaning, verdict.template, verdict.explained = meaning, template, explained
        return verdict

    NONE = (
        "none",
        "no gap beyond the noise",
        "The model agrees with the recording: the residual does not exceed the stated noise.",
        True,
    )
    NAMED = ("named", "one cause, and a clean residual", "{lacks}: {causes}{share}; the residual is clean.", True)
    CLASS = (
        "class",
        "one cause, of several that the data cannot distinguish",
        "{lacks}: {causes}{share}; the residual is clean, but the data cannot distinguish these causes.",
        True,
    )
    COMPOSITE = ("composite", "several causes, and a clean residual", "{lacks}: {causes}{share}.", True)
    PARTIAL = (
        "partial",
        "causes that explain a part of the gap; the rest is unexplained",
        "{lacks}: {causes}{share}, but a part of the gap is unexplained ({left}): these names are not certain.",
        False,
    )
    GENERIC = (
        "generic",
        "a slow disturbance whose cause cannot be determined",
        "A slow disturbance whose cause cannot be determined: {causes}.",
        False,
    )
    UNKNOWN = (
        "unknown",
        "no effect of the library explains the gap well enough",
        "No effect of the library explains the gap well enough ({left}){nearest}{goes_with}.",
        False,
    )
    NOT_OBSERVABLE = (
        "not_observable",
        "on this motion other effects look the same",
        "{lacks}: {causes}; on this motion other effects look the same.",
        False,
    )

    def sentence(self, *, lacks: str = "Missing in the model", **found: str) -> str:
        """State the finding in one sentence for a field engineer; lacks : what the causes are to the model.

        found : the further parts of the template, as causes, share, left, nearest and goes_with.
        """
        return self.template.format(lacks=lacks, **found)
