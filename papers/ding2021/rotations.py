"""Rotations of [Ding2021]'s array: random attitudes beside whole turns about its axes, as other one-step methods need.

The paper says of those methods that they depend on a turntable of three axes, and turns its own array at random.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.models.sensor_array import PER_SENSOR, free_parameters
from papers.base import PaperRow
from papers.ding2021.rows import median_and_range
from papers.ding2021.trials import (
    OFFSETS,
    REFERENCE,
    SENSORS,
    STRENGTH_NT,
    Array4,
    deviations,
    largest_errors,
    simulate,
    vector_of,
)
from papers.judgement import claim, incomparable
from scenarios.arrays import Array

ATTITUDES, CASE, NOISE_NT = 200, 1, 10.0
RANDOM, THREE = "random", "turns about three axes"
TURNS: dict[str, tuple[int, ...]] = {
    THREE: (0, 1, 2),
    "turns about x and y": (0, 1),
    "turns about y and z": (1, 2),
    "turn about the vertical alone": (2,),
}
"""Body axes of each set of whole turns from level; equal shares of the attitudes."""


def turned(axes: tuple[int, ...], n: int = ATTITUDES) -> Array:
    """Return attitudes (n, 3, 3), body to world, of a whole turn about each body axis in sequence, from level."""
    shares = [len(part) for part in np.array_split(np.arange(n), len(axes))]
    turns = [
        Rotation.from_rotvec(np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)[:, None] * np.eye(3)[axis])
        for axis, count in zip(axes, shares, strict=True)
    ]
    return np.concatenate([turn.as_matrix() for turn in turns])


@dataclass(frozen=True)
class RotationResult:
    """Status of a fit; largest error of an offset, nT, NaN where the fit is refused."""

    status: str
    offset_nT: float


@dataclass(frozen=True)
class RotationTrial:
    """Results of a seed by set of attitudes; bound_nT: Cramer-Rao deviation of the least certain offset, RANDOM, THREE.

    The same errors of the array and the same noise in every set.
    """

    results: dict[str, RotationResult]
    bound_nT: dict[str, float]


def rotation_trial(seed: int) -> RotationTrial:
    """Calibrate one array of simulation 1 from each set of attitudes."""
    sets: dict[str, Array | None] = {RANDOM: None} | {name: turned(axes) for name, axes in TURNS.items()}
    arrays = {name: simulate(CASE, NOISE_NT, seed, ATTITUDES, R_wb=R_wb) for name, R_wb in sets.items()}
    results = {name: _result(array) for name, array in arrays.items()}
    return RotationTrial(results, {name: _bound_nT(arrays[name]) for name in (RANDOM, THREE)})


def _result(array: Array4) -> RotationResult:
    fit = LeastSquaresGradiometer(start="two_step").fit(array.recording, REFERENCE)
    if fit.status.kind != "ok":
        return RotationResult(fit.status.kind, float("nan"))
    return RotationResult(fit.status.kind, float(largest_errors(vector_of(fit), array.parameters)[0]))


def _bound_nT(array: Array4) -> float:
    std = deviations(array, NOISE_NT)
    return float(STRENGTH_NT * std[np.isin(free_parameters(SENSORS) % PER_SENSOR, OFFSETS)].max())


def rotation_rows(trials: list[RotationTrial]) -> list[PaperRow]:
    """Return the rows on random attitudes beside turns about three axes, and on fewer axes."""
    return [_three_axes(trials), _fewer(trials)]


def _three_axes(trials: list[RotationTrial]) -> PaperRow:
    error = {name: np.array([t.results[name].offset_nT for t in trials]) for name in (RANDOM, THREE)}
    bounds = {name: float(np.median([t.bound_nT[name] for t in trials])) for name in (RANDOM, THREE)}
    return PaperRow(
        f"{ATTITUDES} random attitudes beside as many on whole {THREE}: largest offset error, noise {NOISE_NT:g} nT",
        "random turns, where other one-step methods depend on a turntable of three axes",
        "; ".join(f"{name} {median_and_range(values, 'nT')}" for name, values in error.items()),
        claim(
            np.median(error[RANDOM]) <= np.median(error[THREE]),
            "median at random at most that of the turns",
            "no figure of the turns is printed",
        ),
        f"{len(trials)} arrays of simulation {CASE}; Cramer-Rao deviation of the least certain offset (median) "
        f"{bounds[RANDOM]:.2f} and {bounds[THREE]:.2f} nT: random attitudes show the whole sphere, three turns three "
        "circles. The attitude itself is not used",
    )


def _fewer(trials: list[RotationTrial]) -> PaperRow:
    names = [name for name in TURNS if name != THREE]
    refused = {name: sum(t.results[name].status == "unobservable" for t in trials) for name in names}
    return PaperRow(
        "whole turns about fewer axes",
        "not tried",
        "; ".join(f"{name}: unobservable in {count} of {len(trials)}" for name, count in refused.items()),
        incomparable("the paper turns its array at random alone"),
        "two circles lie on many ellipsoids, one on more: nine parameters a sensor need a third axis",
    )
