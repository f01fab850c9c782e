"""Statistics of each score by point and calibrator, for the JSON and the tables of a comparison."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from validation.comparison.ranking import uncorrected_row
from validation.comparison.statistics import Interval, mean_square, median, rate
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import SCORE_DEFINITIONS, ScoreDefinition

CLAIMED_INSIDE, CLAIMED_SQUARE = SCORE_DEFINITIONS["offset_inside_95"], SCORE_DEFINITIONS["offset_nees"]
OFFSET_COMPONENTS = 3


@dataclass(frozen=True)
class ScoreStatistic:
    """Statistic of a score of a calibrator at a point.

    found : median with interval; for claims the rate or the mean. ratio : median of score / reference score, trial by
    trial, None without a reference. failures : number of trials with a status other than "ok".
    """

    point: int
    calibrator: str
    score: ScoreDefinition
    found: Interval
    ratio: Interval | None
    failures: int
    trials: int


def score_statistics(table: TrialTable, reference: str | None = None) -> Iterator[ScoreStatistic]:
    """Yield the statistics of all points, calibrators and scores; reference : the calibrator of the ratios."""
    scores = [one for one in SCORE_DEFINITIONS.values() if one.column in table.scores]
    for point in table.points:
        for name in table.calibrators:
            failures = int(table.failed(name, point).sum())
            for score in scores:
                values = table.values(score.column, name, point)
                held = np.isfinite(values)
                if held.any():
                    ratio = (
                        None
                        if reference is None
                        else _ratio(table, score, values, reference_row(reference, name), point)
                    )
                    yield ScoreStatistic(
                        point, name, score, _found(score, values[held], values), ratio, failures, len(values)
                    )


def reference_row(reference: str, name: str) -> str:
    """Return the reference's row name for the sensor of a row."""
    return uncorrected_row(name).replace(uncorrected_row(""), reference, 1)


def _found(score: ScoreDefinition, held: Array, values: Array) -> Interval:
    """Return the rate or mean of a claim over trials with a claim, else the median over all trials."""
    if score is CLAIMED_INSIDE:
        return rate(int(held.sum()), len(held))
    if score is CLAIMED_SQUARE:
        return mean_square(held, OFFSET_COMPONENTS)
    return median(values)


def _ratio(table: TrialTable, score: ScoreDefinition, values: Array, reference: str, point: int) -> Interval | None:
    """Return the median ratio to the reference; None for a score that is no error, or a reference without values."""
    if not score.lower:
        return None
    others = table.values(score.column, reference, point)
    if not (np.isfinite(others) & (others > 0)).all():
        return None
    return median(values / others)
