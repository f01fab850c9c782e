"""Statistics of each score by point and calibrator, for the JSON and the tables of a comparison."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from validation.comparison.ranking import frequent_reason, uncorrected_row
from validation.comparison.statistics import Interval, mean_square, median, rate
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import SCORE_DEFINITIONS, ScoreDefinition

CLAIMED_INSIDE, CLAIMED_SQUARE = SCORE_DEFINITIONS["offset_inside_95"], SCORE_DEFINITIONS["offset_nees"]
OFFSET_COMPONENTS = 3


@dataclass(frozen=True)
class ScoreStatistic:
    """Statistic of a score of a calibrator at a point.

    found : median with interval; for claims the rate or the mean. ratio : median of score / reference score, trial by
    trial, None without a reference. failures : number of trials with a status other than "ok"; reason : their most
    frequent reason.
    """

    point: int
    calibrator: str
    score: ScoreDefinition
    found: Interval
    ratio: Interval | None
    failures: int
    reason: str
    trials: int


def score_statistics(table: TrialTable, reference: str | None = None) -> Iterator[ScoreStatistic]:
    """Yield the statistics of all points, calibrators and scores; reference : the calibrator of the ratios.

    A score that a calibrator gives in no trial is left out, but not where the calibrator gives none: every error is
    infinite then, so that no calibrator is missing.
    """
    scores = [one for one in SCORE_DEFINITIONS.values() if one.column in table.scores]
    for point in table.points:
        for name in table.calibrators:
            values = {score: table.values(score.column, name, point) for score in scores}
            given = [score for score in scores if np.isfinite(values[score]).any()]
            failures, reason = int(table.failed(name, point).sum()), frequent_reason(table, name, point)
            for score in given or [one for one in scores if one.lower]:
                ratio = None if reference is None else _ratio(table, score, values[score], reference, name, point)
                found = _found(score, values[score])
                yield ScoreStatistic(point, name, score, found, ratio, failures, reason, len(values[score]))


def reference_row(reference: str, name: str) -> str:
    """Return the reference's row name for the sensor of a row."""
    return uncorrected_row(name).replace(uncorrected_row(""), reference)


def _found(score: ScoreDefinition, values: Array) -> Interval:
    """Return the rate or mean of a claim over trials with a claim, else the median over all trials."""
    held = values[np.isfinite(values)]
    if score is CLAIMED_INSIDE:
        return rate(int(held.sum()), len(held))
    if score is CLAIMED_SQUARE:
        return mean_square(held, OFFSET_COMPONENTS)
    return median(values)


def _ratio(
    table: TrialTable, score: ScoreDefinition, values: Array, reference: str, name: str, point: int
) -> Interval | None:
    """Return the median ratio to the reference; None for a score that is no error, or a reference without values."""
    if not score.lower:
        return None
    others = table.values(score.column, reference_row(reference, name), point)
    if not (np.isfinite(others) & (others > 0)).all():
        return None
    return median(values / others)
