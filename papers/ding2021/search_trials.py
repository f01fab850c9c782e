"""Trials of [Ding2021]'s searches: populations, F and CR, numbers of attitudes, and starts of least squares."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.families.gradiometer import ArrayEstimate, GradiometerCalibrator, polished
from calib.methods.de_gradiometer import DeGradiometer
from calib.methods.ga_gradiometer import GaGradiometer
from calib.methods.ide_gradiometer import IdeGradiometer
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.models.sensor_array import ArrayObjective, maps
from papers.ding2021.trials import (
    REFERENCE,
    SENSORS,
    STRENGTH_NT,
    largest_errors,
    nominal,
    residual_rms,
    searched,
    simulate,
    task_of,
    vector_of,
)
from scenarios.arrays import Array
from scenarios.seeds import stream

SIZES = (10, 15, 20, 50, 100, 200)
COUNTS = (10, 20, 50, 100, 200, 500)
FACTORS = tuple((f, c) for f in (0.2, 0.45, 0.7, 0.9) for c in (0.2, 0.5, 0.8, 1.0))
EVOLUTION, GENETIC = IdeGradiometer(polish=False), GaGradiometer(polish=False)
LARGE = replace(EVOLUTION, population=200)
TIGHT = IdeGradiometer(polish=False, offset_fraction=0.005, scale_range=0.125, angle_deg=2.5)


@dataclass(frozen=True)
class SearchTask:
    """A search without noise in simulation 1, over n attitudes."""

    method: GradiometerCalibrator
    seed: int
    n: int = 200


def search_trial(task: SearchTask) -> dict[str, Any]:
    """Return history of the objective's rms (nT), final rms of total plus tensor, and offset error (nT)."""
    array = simulate(1, 0.0, task.seed, task.n)
    assert array.recording.array_mag_nT is not None
    found = searched(task.method, array, task.seed)
    history = np.array(found.history)
    return {
        "history": history,
        "errors": largest_errors(found.parameters, array.parameters),
        "rms": float(residual_rms(found.parameters, array.recording.array_mag_nT).sum()),
    }


@dataclass(frozen=True)
class StartTask:
    """Levenberg-Marquardt from random starts in boxes of growing size, in simulation 1 with 10 nT of noise."""

    seed: int


STARTS = {
    "the paper's ranges": (200.0, 0.1, 2.0),
    "our search space": (5_200.0, 0.2, 5.0),
    "20 % of F, 0.5 to 1.5, 30 deg": (10_400.0, 0.5, 30.0),
    "F, 0.2 to 1.8, 90 deg": (52_000.0, 0.8, 90.0),
}
"""Half widths of the starts: offset (nT), scale, angles (degrees)."""


def start_trial(task: StartTask) -> dict[str, bool]:
    """Return for each box, and for the nominal start, whether the minimum of the two-step start was reached."""
    array = simulate(1, 10.0, task.seed)
    objective = task_of(array, IdeGradiometer())
    best = vector_of(LeastSquaresGradiometer(start="two_step").fit(array.recording, REFERENCE))
    draw = stream(2021, task.seed, "starts")
    tried = {"nominal": nominal()}
    for name, (offset_nT, scale, angle_deg) in STARTS.items():
        reach = np.tile([offset_nT / STRENGTH_NT] * 3 + [scale] * 3 + [np.radians(angle_deg)] * 6, SENSORS)
        tried[name] = nominal() + draw.uniform(-1, 1, 48) * reach
        tried[name][9:12] = 0.0
    return {name: _same(objective, start, best) for name, start in tried.items()}


def _same(objective: ArrayObjective, start: Array, best: Array) -> bool:
    try:
        with np.errstate(all="ignore"):
            found = polished(objective, ArrayEstimate(start)).parameters
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return False
    ours, theirs = (maps(p, SENSORS)[0] for p in (found, best))
    return bool(np.abs(ours - theirs).max() < 1e-6)


def populations() -> list[GradiometerCalibrator]:
    """Return the improved evolution with each population."""
    return [replace(EVOLUTION, population=n) for n in SIZES]


def improved_and_classic() -> tuple[list[GradiometerCalibrator], list[GradiometerCalibrator]]:
    """Return the improved and the classic evolution with each (F, CR)."""
    return (
        [IdeGradiometer(polish=False, mutation=f, crossover=c) for f, c in FACTORS],
        [DeGradiometer(polish=False, mutation=f, crossover=c) for f, c in FACTORS],
    )


def searches(few: int, evolved: int) -> Iterable[SearchTask]:
    """Yield the searches without noise: populations, genetic algorithm, numbers of attitudes, F and CR of two methods.

    few: seeds of every search but the pairs (F, CR); evolved: seeds of each pair.
    """
    for method in (*populations(), GENETIC, TIGHT):
        yield from (SearchTask(method, seed) for seed in range(few))
    yield from (SearchTask(LARGE, seed, n) for n in COUNTS if n != 200 for seed in range(few))
    for methods in improved_and_classic():
        yield from (SearchTask(method, seed) for method in methods for seed in range(evolved))
