"""Scores as ratios to the bound: how far a calibrator is from what any method could reach with what it is told."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib import CALIBRATORS
from scenarios.errors import InputError
from sim.scenario import Scenario
from sim.simulate import Plan, plan
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import run_experiment
from validation.bound.stated import stated_noise_nT
from validation.bound.uses import uses
from validation.scoring.meaning import MEANINGS

Array = NDArray[np.float64]
OTHER_SENSORS = {"scalar", "array"}
"""What tells a method more than one magnetometer does: no bound is known for it."""


def knowledge_of(name: str, *, attitude_free: bool, eddy: bool = False) -> str | None:
    """What a calibrator is told of the field, and whether it finds eddy currents beside it, by the word of `KNOWLEDGE`.

    None for other or several sensors.
    """
    needs = set(CALIBRATORS[name].needs) if name in CALIBRATORS else set()
    if "@" in name or needs & OTHER_SENSORS:
        return None
    if not attitude_free:
        return "vector+eddy" if eddy else "vector"
    return "+".join(["norm", *(one for one in ("gyro", "accel") if one in needs)])


def least_scores(scenario: Scenario, knowledges: set[str]) -> dict[tuple[str, str], float]:
    """The least rms of scores over runs, by what is known and the score's column; of the scenario's first run."""
    return least_in(plan(scenario), knowledges)


def least_in(run: Plan, knowledges: set[str]) -> dict[tuple[str, str], float]:
    """The same of a run.

    Empty where there is no bound: without noise, or where the vehicle cannot do the motion.
    """
    try:
        return least_of(run_experiment(run, stated_noise_nT(run.effects[0])), knowledges)
    except InputError:
        return {}


def least_of(known: Experiment, knowledges: set[str]) -> dict[tuple[str, str], float]:
    """The same of an experiment."""
    found: dict[tuple[str, str], float] = {}
    for knowledge in sorted(knowledges):
        bound = Bound.of(known, knowledge)
        found[knowledge, MEANINGS["offset_error"].column] = bound.offset_rms_nT
        found |= {(knowledge, one.meaning.column): one.value for one in uses(known, bound)}
    return found


def bound_ratio(values: Array, least: float | None) -> float | None:
    """Rms of a score over the trials with an estimate, over the least that any method can reach; None without one."""
    finite = values[np.isfinite(values)]
    if least is None or not 0 < least < np.inf or not len(finite):
        return None
    return float(np.sqrt(np.mean(finite**2)) / least)
