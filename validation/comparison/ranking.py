"""Ranking of calibrators by a score over the trials of a comparison, and the resulting recommendation."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from scenarios.arrays import Array
from validation.comparison.statistics import LEVEL, Difference, Interval, differences, median, rate, width_ratio
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import ScoreDefinition
from validation.scoring.evaluation import UNCORRECTED
from validation.text import counted, figure

LONGEST_REASON = 120
"""Characters of a failure's reason in a sentence; the table holds the whole reason."""
CLAUSE = re.compile("[:;] ")
"""Where a clause of a reason ends."""
MOST_NAMED = 5
"""Largest number of failing calibrators that a sentence names."""
MOST_FAILED = 0.5
"""Share of failed trials above which a calibrator ranks behind all others, whatever the score."""


@dataclass(frozen=True)
class RankedCalibrator:
    """Calibrator at a point: median score, number and rate of failures, most frequent reason."""

    calibrator: str
    median: Interval
    failures: int
    failure_rate: Interval
    reason: str

    @property
    def place(self) -> tuple[bool, float]:
        """Sort key: calibrators that mostly fail last, the rest by median."""
        return self.failure_rate.value > MOST_FAILED, self.median.value


@dataclass(frozen=True)
class Ranking:
    """Calibrators at a point, best first, with pairwise differences and the score of the raw measurement."""

    score: ScoreDefinition
    trials: int
    calibrators: tuple[RankedCalibrator, ...]
    differences: tuple[Difference, ...]
    uncorrected: Interval
    better_than_none: int
    """Number of trials in which the best calibrator beats the raw measurement."""

    @property
    def best(self) -> RankedCalibrator:
        """The best calibrator."""
        return self.calibrators[0]

    @property
    def rivals(self) -> list[str]:
        """Calibrators that are not significantly worse than the best."""
        usable = [one.calibrator for one in self.calibrators[1:] if not one.place[0]]
        return [name for name in usable if not self.against(name).clear]

    @property
    def cost(self) -> str:
        """What the intervals hold for, and what that costs in width."""
        ratio = figure(width_ratio(self.trials), 2)
        times = "" if ratio == "1" else f"{ratio} times "
        wide = f"{times}as wide as for {counted(self.trials, 'trial')} fixed in advance"
        return f"intervals and clear differences hold at {100 * LEVEL:g} % however often trials are added: {wide}"

    def against(self, other: str) -> Difference:
        """Return the difference between the best calibrator and `other`, counted for the best."""
        for found in self.differences:
            if {found.one, found.other} == {self.best.calibrator, other}:
                return found if found.other == other else found.turned()
        raise KeyError(other)

    @property
    def sentence(self) -> str:
        """The recommendation in a sentence."""
        between = ": " if self.best.place[0] else "; "
        return between.join(filter(None, (self._recommended(), self._failing())))

    def _recommended(self) -> str:
        best, n = self.best, self.trials
        if best.place[0]:
            return "none can be used here"
        if not best.median.value < self.uncorrected.value:
            left = f"{self._with_ends(best.median)}, without correction {self._with_ends(self.uncorrected)}"
            return f"use none of them: {best.calibrator} leaves {left} {self.score.setting}"
        return f"use {self._names()}: {self._with_ends(best.median)} {self.score.setting}, {self._compared()}; " + (
            f"fails in {best.failures} of {n}"
        )

    def _failing(self) -> str:
        """Return the failures and the first message of each calibrator that fails in most trials."""
        mostly = [one for one in self.calibrators if one.place[0]]
        named = [
            f"{one.calibrator} fails in {one.failures} of {self.trials} trials{quoted(one.reason)}" for one in mostly
        ]
        more = [f"{len(mostly) - MOST_NAMED} more fail in most"] if len(mostly) > MOST_NAMED else []
        return "; ".join(named[:MOST_NAMED] + more)

    def _names(self) -> str:
        names = [self.best.calibrator, *self.rivals]
        return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"

    def _compared(self) -> str:
        """Return the best calibrator's wins over the next, over each rival, or over no correction."""
        n = self.trials
        if len(self.calibrators) == 1:
            return f"better than no correction in {self.better_than_none} of {n} trials"
        if not self.rivals:
            second = self.calibrators[1].calibrator
            return f"better than {second} in {self.against(second).better} of {n} trials"
        wins = sorted(self.against(name).better for name in self.rivals)
        often = str(wins[0]) if wins[0] == wins[-1] else f"{wins[0]} to {wins[-1]}"
        named = self.rivals[0] if len(wins) == 1 else "each of the others"
        return f"no clear difference ({self.best.calibrator} better than {named} in {often} of {n} trials)"

    def _with_ends(self, found: Interval) -> str:
        unit = f" {self.score.unit}" if self.score.unit else ""
        return f"{figure(found.value)}{unit} [{figure(found.low)}, {figure(found.high)}]"


def rank_calibrators(table: TrialTable, score: ScoreDefinition, point: int = 0) -> Ranking:
    """Rank the calibrators by a score at a point."""
    values = {name: table.values(score.column, name, point) for name in table.candidates}
    calibrators = sorted((_ranked(table, name, values[name], point) for name in values), key=lambda one: one.place)
    best = calibrators[0].calibrator
    raw = table.values(score.column, uncorrected_row(best), point)
    better = int(np.sum(values[best] < raw))
    return Ranking(score, len(raw), tuple(calibrators), tuple(differences(values)), median(raw), better)


def uncorrected_row(name: str) -> str:
    """Return the raw measurement's row name for the sensor of a calibrator's row."""
    _, at, sensor = name.partition("@")
    return f"{UNCORRECTED}{at}{sensor}"


def _ranked(table: TrialTable, name: str, values: Array, point: int) -> RankedCalibrator:
    failures = int(table.failed(name, point).sum())
    reason = frequent_reason(table, name, point)
    return RankedCalibrator(name, median(values), failures, rate(failures, len(values)), reason)


def frequent_reason(table: TrialTable, name: str, point: int = 0) -> str:
    """Return the most frequent reason of a calibrator's failures at a point, "" without any."""
    reasons = Counter(compress(table.texts("reason", name, point), table.failed(name, point)))
    return max(reasons, key=lambda text: reasons[text], default="")


def quoted(reason: str) -> str:
    """Return a reason for the end of a sentence: its clauses within LONGEST_REASON characters, else its first words."""
    words = " ".join(reason.split())
    if len(words) <= LONGEST_REASON:
        return f": {words}" if words else ""
    start = words[: LONGEST_REASON + 1]
    clauses = [match.start() for match in CLAUSE.finditer(start)]
    return f": {start[: clauses[-1]]}" if clauses else f": {start.rpartition(' ')[0]} ..."


def overall_sentence(answers: Sequence[Ranking], points: Sequence[str]) -> str:
    """Return the summary sentence of a comparison: the best calibrator over all points, then each point."""
    if len(answers) == 1:
        return answers[0].sentence
    wins = Counter(one.best.calibrator for one in answers if not one.best.place[0])
    if not wins:
        return f"none can be used at any of {counted(len(answers), 'point')}: {answers[0].sentence}"
    name = max(wins, key=lambda one: wins[one])
    where = "every one" if wins[name] == len(answers) else f"{wins[name]}"
    at = "; ".join(f"at {point} {one.sentence}" for point, one in zip(points, answers, strict=True))
    return f"use {name}, the best at {where} of {counted(len(answers), 'point')}: {at}"
