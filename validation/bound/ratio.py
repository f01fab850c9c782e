"""Scores as ratios to the Cramer-Rao bound for the information given to a calibrator."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.motion_cache import MotionCache
from sim.simulation import PreparedRun
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import run_experiment
from validation.bound.information import directed
from validation.bound.knowledge import COLOURED
from validation.bound.score_bounds import score_bounds
from validation.scoring.definitions import SCORE_DEFINITIONS

OTHER_SENSORS = {"scalar", "array"}
"""Needs of calibrators with more sensors than a magnetometer, without a bound."""
LeastErrors = dict[tuple[str, str], float]
"""Least rms of scores, by knowledge of the field and column of the score."""


def knowledge_of(name: str, needs: Collection[str], *, attitude_free: bool, eddy: bool = False) -> str | None:
    """Return a calibrator's knowledge of the field, and of eddy currents if estimated, as a key of KNOWLEDGE.

    needs : quantities that the calibrator needs of a recording, keys of NEEDS. None for other or several sensors, for
    an accelerometer without a gyro, and for a vector without a measured attitude.
    """
    alone = any(one in needs and other not in needs for one, other in (("accel", "gyro"), ("field_vector", "attitude")))
    if "@" in name or alone or OTHER_SENSORS & set(needs):
        return None
    if not attitude_free:
        return "vector+eddy" if eddy else "vector"
    return "+".join(["norm", *(one for one in ("gyro", "accel") if one in needs)])


def least_errors_in(run: PreparedRun, knowledges: set[str], flights: MotionCache | None = None) -> LeastErrors:
    """Return the least rms of scores over trials of a run with the stated noise; flights : cache of motions.

    Empty without a bound: no noise, or a vehicle that cannot perform the motion.
    """
    try:
        motions = None if flights is None else flights.motions(run)
        return least_errors(run_experiment(run, coloured=True, motions=motions), knowledges)
    except InputError:
        return {}


def least_errors(known: Experiment, knowledges: set[str]) -> LeastErrors:
    """Return the least rms of scores of an experiment.

    No bound covers a gyro together with coloured noise: the larger of two lower bounds is taken, for white noise alone
    and for known directions.
    """
    found: LeastErrors = {}
    for knowledge in sorted(knowledges):
        if known.colour is None or knowledge in COLOURED:
            found |= _errors_of(known, Bound.of(known, knowledge))
            continue
        white = _errors_of(known, Bound.of(replace(known, colour=None), knowledge))
        lasting = _errors_of(known, Bound(knowledge, known.strength_nT, directed(known)))
        found |= {key: max(value, lasting[key]) for key, value in white.items()}
    return found


def _errors_of(known: Experiment, bound: Bound) -> LeastErrors:
    least = {(bound.knowledge, SCORE_DEFINITIONS["offset_error"].column): bound.offset_rms_nT}
    return least | {(bound.knowledge, one.meaning.column): one.value for one in score_bounds(known, bound)}


def bound_ratio(values: Array, least: Array) -> float | None:
    """Return the rms over trials of score (n,) over bound (n,); trials without estimate or bound are left out.

    None if no trial is left.
    """
    valid = np.isfinite(values) & np.isfinite(least) & (least > 0)
    return float(np.sqrt(np.mean((values[valid] / least[valid]) ** 2))) if valid.any() else None
