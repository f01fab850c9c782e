"""Recommended calibrator of a run, with the expected errors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from calib import Calibration, Status
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.evaluation import UNCORRECTED
from validation.scoring.scores import Score
from validation.text import quantity

Calibrations = Mapping[str, Calibration]
Scores = Mapping[str, Sequence[Score]]
HEADING = "heading_rms"
"""Score reported next to the ranking score: the heading error matters to a navigator."""
FAILED = {
    "not_converged": "it did not converge",
    "unobservable": "the data do not determine its parameters",
    "not_applicable": "it does not apply",
}
"""Wording of a failed status in a sentence."""


@dataclass(frozen=True)
class Recommendation:
    """Recommended calibrator of a run.

    use : name of the calibrator, "" where no calibrator is usable. sentence : what to do and what to expect.
    failed : status of each failed calibrator, best first. closer : a sentence for each failed calibrator with a
    smaller error than the recommended one.
    """

    use: str
    sentence: str
    failed: dict[str, Status]
    closer: tuple[str, ...]

    def plain(self) -> dict[str, Any]:
        """Return plain values for JSON; `use` is None where no calibrator is usable."""
        failed = [
            {"calibrator": name, "status": status.kind, "reason": status.reason} for name, status in self.failed.items()
        ]
        return {"use": self.use or None, "sentence": self.sentence, "failed": failed, "closer": list(self.closer)}


@dataclass(frozen=True)
class MethodScore:
    """Scores of a calibrator, or of no correction, over all sensors of a run; the worst sensor counts."""

    name: str
    keys: tuple[str, ...]
    scores: Scores

    @classmethod
    def each(cls, keys: Sequence[str], scores: Scores) -> list[MethodScore]:
        """Group keys, `name` or `name@sensor`, by calibrator in the given order."""
        names = dict.fromkeys(key.split("@")[0] for key in keys)
        return [cls(name, tuple(key for key in keys if key.split("@")[0] == name), scores) for name in names]

    def score(self, name: str) -> Score | None:
        """Return the worst sensor's score; None where a sensor has no finite score."""
        found = [one for key in self.keys for one in self.scores.get(key, ()) if one.name == name]
        finite = [one for one in found if math.isfinite(one.value)]
        return max(finite, key=lambda one: one.value) if finite and len(finite) == len(self.keys) else None

    def error(self, name: str) -> float:
        """Return the worst sensor's value, infinite where missing."""
        found = self.score(name)
        return found.value if found else math.inf

    def pointless(self, raw: MethodScore, by: str) -> bool:
        """Return whether the error is finite and not below the raw measurement's."""
        return raw.error(by) <= self.error(by) < math.inf

    def expected(self, by: str) -> str:
        """ "1.3 nT on a level survey, heading 0.02°"."""
        ranking, heading = self.score(by), self.score(HEADING)
        parts = [f"{quantity(ranking.value, ranking.unit)} {SCORE_DEFINITIONS[by].setting}"] if ranking else []
        if heading and by != HEADING:
            turned = " after one alignment with the vehicle" if heading.rotation_removed else ""
            parts.append(f"heading {quantity(heading.value, heading.unit)}{turned}")
        worst = f" (the worst of {len(self.keys)} sensors)" if parts and len(self.keys) > 1 else ""
        return ", ".join(parts) + worst


def recommend(calibrations: Calibrations, scores: Scores, by: str, ranking: Sequence[str]) -> Recommendation:
    """Recommend the calibrator with the lowest score among the calibrators of status "ok" on every sensor.

    No calibrator is recommended where the raw measurement is as good. by : name of the score. ranking : keys of the
    calibrations, best first.
    """
    raw = MethodScore(UNCORRECTED, tuple(key for key in scores if key.split("@")[0] == UNCORRECTED), scores)
    methods = MethodScore.each(ranking, scores)
    failed = {key: status for key in ranking if (status := calibrations[key].status).kind != "ok"}
    usable = [one for one in methods if not failed.keys() & set(one.keys)]
    best = min(usable, key=lambda one: one.error(by), default=None)
    use = best if best and not best.pointless(raw, by) else None
    closer = _closer([one for one in methods if one not in usable], use or raw, failed, by)
    return Recommendation(use.name if use else "", _sentence(methods, best, use, raw, by), failed, closer)


def _sentence(
    methods: Sequence[MethodScore], best: MethodScore | None, use: MethodScore | None, raw: MethodScore, by: str
) -> str:
    """Return the recommendation in words, with the expected errors."""
    without = f"; without correction {raw.expected(by)}" if raw.expected(by) else ""
    if not methods:
        return f"no calibrator was asked for{without}"
    if best is None:
        return f"none can be used here: {'all ' if len(methods) > 1 else ''}{len(methods)} failed{without}"
    if use is None:
        return f"use none of them: {best.name}, the best, leaves {best.expected(by)}{without}"
    expected = f": {use.expected(by)}" if use.expected(by) else ""
    return f"use {use.name}{expected}{without}"


def _closer(
    unusable: Sequence[MethodScore], other: MethodScore, failed: Mapping[str, Status], by: str
) -> tuple[str, ...]:
    """Return a sentence for each failed calibrator with a smaller error than the recommended calibrator."""
    than = "no correction" if other.name == UNCORRECTED else other.name
    return tuple(
        f"{one.name} has a smaller error here than {than}, {quantity(one.error(by), SCORE_DEFINITIONS[by].unit)}, but "
        f"reports that {_failure_reason(one, failed)}, so it cannot be known beforehand"
        for one in unusable
        if one.error(by) < other.error(by) < math.inf
    )


def _failure_reason(one: MethodScore, failed: Mapping[str, Status]) -> str:
    """Return why a calibrator failed: status and reason."""
    status = next(failed[key] for key in one.keys if key in failed)
    reason = status.reason.partition(": ")[0]
    return FAILED[status.kind] + (f' ("{reason}")' if reason else "")
