"""The iron of a stated calibration against the iron of a recording, beside the recording's diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sim.effects.iron import HardIron, SoftIron
from validation.rechecking.parts import JOINT, OFFSET, SOFT_IRON
from validation.rechecking.recheck import Recheck
from validation.rechecking.summary import HEADS, headline, rows, summary

EFFECTS = {OFFSET: HardIron.name, SOFT_IRON: SoftIron.name, JOINT: f"{HardIron.name} or {SoftIron.name}"}
"""Effect by part of a change."""
IRON_HEADS = ("recording", *HEADS)


@dataclass(frozen=True, eq=False)
class StatedIron:
    """Whether the calibration that a diagnosis was given holds in a recording, by name."""

    recording: str
    answer: Recheck

    @property
    def sentence(self) -> str:
        """Return the answer in a sentence."""
        return f"the stated calibration, {self.recording}: {headline(self.answer)}"

    @property
    def rows(self) -> list[list[str]]:
        """Return a row a part, cells of IRON_HEADS."""
        return [[self.recording, *row] for row in rows(self.answer)]

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as JSON: verdict, and each changed effect by name, with 95 % intervals."""
        told = summary(self.answer)
        causes = [{"effect": EFFECTS.get(one["what"], one["what"])} | one for one in told["changes"]]
        kept = ("verdict", "sentence", "heading_error_deg", "parts", "notes")
        return {"recording": self.recording} | {key: told[key] for key in kept} | {"changed": causes}
