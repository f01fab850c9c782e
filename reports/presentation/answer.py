"""Words common to the diagnosis of a single recording and of several recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.localise import ChannelShare
from diagnosis.verdict import Verdict
from reports.presentation.stated_iron import StatedIron
from validation.text import digits


@dataclass(frozen=True, kw_only=True)
class PresentedAnswer:
    """Verdict, sentence and advice; tiles (value, label); the new model with its change, and the JSON of `--json`.

    date : of the recording, where its log tells one. stated : the calibration that was stated in place of a model,
    against each recording.
    """

    verdict: Verdict
    sentence: str
    advice: tuple[str, ...]
    tiles: tuple[tuple[str, str], ...]
    gaps: tuple[tuple[str, ...], ...]
    where: tuple[ChannelShare, ...]
    not_observable: tuple[str, ...]
    diff: tuple[str, ...]
    model: str
    summary: dict[str, Any]
    date: str = ""
    stated: tuple[StatedIron, ...] = ()

    @property
    def headline(self) -> str:
        """The stated calibration's answer, verdict, sentence and advice as lines of text."""
        lines = [one.sentence for one in self.stated]
        lines += [f"verdict: {self.verdict} ({self.verdict.meaning})", self.sentence]
        if self.advice:
            lines += ["", "what to do next", *(f"{i}. {line}" for i, line in enumerate(self.advice, start=1))]
        return "\n".join(lines)

    def beside(self, stated: Sequence[StatedIron]) -> Self:
        """Return the answer with that on a stated calibration, in the JSON too."""
        if not stated:
            return self
        told = {"stated_calibration": [one.as_dict() for one in stated]}
        return replace(self, stated=tuple(stated), summary=self.summary | told)


def noise_tile(gap: GapSize) -> tuple[str, str]:
    """Return the tile of a gap that is no larger than the noise."""
    return f"{digits(gap.before_sigma)} times", "the noise, rms with iron refitted: no gap beyond the noise"


def gap_cells(gap: GapSize) -> tuple[str, ...]:
    """Return rms before and after in nT and in units of the noise, and the share explained."""
    sizes = (digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma))
    return (*sizes, "no gap" if gap.explained is None else f"{100 * gap.explained:.1f} %")
