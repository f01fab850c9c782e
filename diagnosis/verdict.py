"""The verdicts of a diagnosis: word, meaning, sentence, and whether the gap counts as explained."""

from __future__ import annotations

from enum import StrEnum


class Verdict(StrEnum):
    """A verdict is its word; `meaning` says it in general, `sentence` of one case.

    explained : whether no gap is left without a cause, which is exit status 0 of `magbench diagnose`, else 1.
    """

    meaning: str
    template: str
    explained: bool

    def __new__(cls, word: str, meaning: str, template: str, explained: bool) -> Verdict:
        """A word with what belongs to it."""
        verdict = str.__new__(cls, word)
        verdict._value_ = word
        verdict.meaning, verdict.template, verdict.explained = meaning, template, explained
        return verdict

    NONE = (
        "none",
        "no gap beyond the noise",
        "The model agrees with the recording: what is left is no more than the noise that it states.",
        True,
    )
    NAMED = (
        "named",
        "one cause, and what is left is clean",
        "Missing in the model: {causes}{share}; what is left is clean.",
        True,
    )
    CLASS = (
        "class",
        "one cause, of several that the data do not tell apart",
        "Missing in the model: {causes}{share}; what is left is clean, but the data do not tell them apart.",
        True,
    )
    COMPOSITE = (
        "composite",
        "several causes, and what is left is clean",
        "Missing in the model: {causes}{share}.",
        True,
    )
    PARTIAL = (
        "partial",
        "causes that explain a part of the gap, but something is left",
        "Missing in the model: {causes}{share}, but something else is left ({left}).",
        False,
    )
    GENERIC = (
        "generic",
        "a slow disturbance whose cause the data do not tell",
        "A slow disturbance whose cause the data do not tell: {causes}.",
        False,
    )
    UNKNOWN = (
        "unknown",
        "no effect of the library explains the gap well enough",
        "Something is missing that no effect of the library explains well enough ({left}){nearest}{goes_with}.",
        False,
    )
    NOT_OBSERVABLE = (
        "not_observable",
        "on this motion other effects look the same",
        "Missing in the model: {causes}; on this motion other effects look the same.",
        False,
    )

    def sentence(self, *, causes: str, share: str, left: str, nearest: str, goes_with: str) -> str:
        """The finding in one sentence for a field engineer."""
        return self.template.format(causes=causes, share=share, left=left, nearest=nearest, goes_with=goes_with)
