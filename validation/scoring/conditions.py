"""Failure conditions on a score of a run: `ellipsoid.heading_rms > 0.1`."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from scenarios.errors import InputError
from scenarios.names import closest
from validation.scoring.definitions import ScoreDefinition, score_definition
from validation.scoring.scores import Score
from validation.text import figure

COMPARE = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
FORM = re.compile(r"\s*(?P<calibrator>\S+)\.(?P<score>\w+)\s*(?P<sign>[<>]=?)\s*(?P<limit>\S+)(?:\s+(?P<unit>\w+))?\s*")
EXAMPLE = "write 'ellipsoid.heading_rms > 0.1', with <, <=, > or >="


def row_names(calibrators: Iterable[str], sensors: int) -> list[str]:
    """Return the keys of scores: the calibrators' names, for an array name@1, name@2 ..."""
    if sensors == 1:
        return list(calibrators)
    return [f"{name}@{sensor}" for name in calibrators for sensor in range(1, sensors + 1)]


@dataclass(frozen=True)
class Condition:
    """CALIBRATOR.SCORE SIGN LIMIT, limit in the score's unit; a missing score counts as a failure.

    text : as written by the user. where : the command-line option.
    """

    text: str
    calibrator: str
    score: ScoreDefinition
    sign: str
    limit: float
    where: str

    @classmethod
    def parsed(cls, text: str, where: str) -> Condition:
        """Parse a condition; InputError for a wrong form, an unknown score, and a unit that is not the score's."""
        found = FORM.fullmatch(text)
        try:
            limit = float(found["limit"]) if found else math.nan
        except ValueError:
            limit = math.nan
        if not found or math.isnan(limit):
            raise InputError(f"{text!r} is no condition on a score", where=where, do=EXAMPLE)
        score = score_definition(found["score"], f"{where} {text}")
        if found["unit"] not in (None, score.unit):
            unit = score.unit or "no unit"
            raise InputError(f"{score.name} is in {unit}, not in {found['unit']}", where=where, do=f"write {unit}")
        return cls(text, found["calibrator"], score, found["sign"], limit, where)

    def check(self, calibrators: Iterable[str]) -> None:
        """Raise InputError where the condition's calibrator is not in the run."""
        known = list(calibrators)
        if self.calibrator not in known:
            what = f"no calibrator {self.calibrator!r} in this run"
            raise InputError(what, where=f"{self.where} {self.text}", do=closest(self.calibrator, known, len(known)))

    def failure(self, scores: Mapping[str, Sequence[Score]]) -> str:
        """Return a line with the score where the condition holds or the score is missing, else ""."""
        value = next((one.value for one in scores[self.calibrator] if one.name == self.score.name), None)
        what = f"{self.calibrator}.{self.score.name}"
        if value is None:
            return f"there is no {what}, as {self.where} {self.text!r} asks"
        if not COMPARE[self.sign](value, self.limit):
            return ""
        return f"{what} is {figure(value)} {self.score.unit}".rstrip() + f", failed by {self.where} {self.text!r}"
