"""Scores as ratios to the bound: how far a calibrator is from what any method could reach with what it is told."""

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
from validation.bound.score_bounds import uses
from validation.bound.sensor_noise import stated_noise_nT
from validation.scoring.definitions import SCORE_DEFINITIONS

OTHER_SENSORS = {"scalar", "array"}
"""What tells a method more than one magnetometer does: no bound is known for it."""
Leasts = dict[tuple[str, str], float]
"""The least rms of scores, by what is known of the field and the score's column."""


def knowledge_of(name: str, needs: Collection[str], *, attitude_free: bool, eddy: bool = False) -> str | None:
    """What a calibrator is told of the field, and whether it finds eddy currents beside it, by the word of `KNOWLEDGE`.

    needs : what it says it needs of a recording, keys of NEEDS. None for other or several sensors.
    """
    if "@" in name or OTHER_SENSORS & set(needs):
        return None
    if not attitude_free:
        return "vector+eddy" if eddy else "vector"
    return "+".join(["norm", *(one for one in ("gyro", "accel") if one in needs and "gyro" in needs)])


def least_in(run: PreparedRun, knowledges: set[str], flights: MotionCache | None = None) -> Leasts:
    """The least rms of scores over trials of one run, its noise as stated; flights: motions that may be used again.

    Empty where there is no bound: without noise, or where the vehicle cannot do the motion.
    """
    try:
        motions = None if flights is None else flights.motions(run)
        noise = stated_noise_nT(run.effects[0])
        return least_of(run_experiment(run, noise, coloured=True, motions=motions), knowledges)
    except InputError:
        return {}


def least_of(known: Experiment, knowledges: set[str]) -> Leasts:
    """The same of an experiment.

    Where a gyro links the samples and noise lasts no bound counts both: no method is below the larger of that of the
    white noise alone and that of known directions.
    """
    found: Leasts = {}
    for knowledge in sorted(knowledges):
        if known.colour is None or knowledge in COLOURED:
            found |= _leasts(known, Bound.of(known, knowledge))
            continue
        white = _leasts(known, Bound.of(replace(known, colour=None), knowledge))
        lasting = _leasts(known, Bound(knowledge, known.strength_nT, directed(known)))
        found |= {key: max(value, lasting[key]) for key, value in white.items()}
    return found


def _leasts(known: Experiment, bound: Bound) -> Leasts:
    least = {(bound.knowledge, SCORE_DEFINITIONS["offset_error"].column): bound.offset_rms_nT}
    return least | {(bound.knowledge, one.meaning.column): one.value for one in uses(known, bound)}


def bound_ratio(values: Array, least: Array) -> float | None:
    """Rms over the trials with an estimate of a score (n,) over the least (n,) that any method can reach in its run.

    Trials in whose run there is no such limit, which is none, NaN or infinite, are left out; None where all are.
    """
    told = np.isfinite(values) & np.isfinite(least) & (least > 0)
    return float(np.sqrt(np.mean((values[told] / least[told]) ** 2))) if told.any() else None
