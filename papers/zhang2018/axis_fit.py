"""Particle swarm with rotation-axis fit, to which [Zhang2018] refers (its reference 2, [RiwantoEtAl2017]).

The strength leaves a rotation Q of the calibrated field open (eq. 10). In a turn about a body axis the field keeps its
part along that axis, so the end of R (m - b) runs on a circle whose normal is Q^T times the axis: the normals of turns
about known axes give Q. The paper prints no figure of the method; order of search and fit is our choice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.families.norm_search import triangular
from calib.methods.pso import Pso
from papers.attitudes import state_at_attitudes
from papers.base import PaperRow, spread_text
from papers.judgement import incomparable
from papers.zhang2018.trials import (
    NOISE_NT,
    PRINTED_SOFT,
    SEED,
    bounded,
    effects,
    level_nT,
    spiral,
    strength_nT,
    true_offset_nT,
)
from scenarios.arrays import Array
from scenarios.seeds import stream
from validation.signals.amplitude import rms

STEP_DEG = 2.0
"""Angle between samples of the three turns."""
SEARCH = Pso(iterations=1000, c1=1.494, c2=1.494, polish=False)
"""200 iterations, as printed, leave the swarm on its way; c as in the literature."""
REACH_NT, WIDTH = 1000.0, 0.2
"""Half widths of the search for the hard iron and for R: eq. 7's R departs from the identity by 0.107."""
TURNS, CIRCLES = "turns about three axes", "circles of the AUV"


@dataclass(frozen=True)
class AxisErrors:
    """Results of a seed by motion: rms error of the components, nT, by the swarm alone and with fit.

    angle_deg: turn that the fit takes off; offset_nT: error of the hard iron. The noise is part of the errors.
    """

    alone_nT: dict[str, float]
    fitted_nT: dict[str, float]
    angle_deg: dict[str, float]
    offset_nT: dict[str, float]


@dataclass(frozen=True, eq=False)
class Turned:
    """Measured and true field mag_nT, true_nT (k, n, 3) on turns about unit axes (k, 3); offset_nT: true iron (3,)."""

    mag_nT: Array
    true_nT: Array
    axes: Array
    offset_nT: Array


def rotation(normals: Array, axes: Array) -> Array:
    """Return Q (3, 3) of least sum_k |Q n_k - e_k|^2 for unit normals n and axes e (k, 3), the smallest if one axis."""
    if len(axes) == 1:
        return np.asarray(_shortest(normals[0], axes[0]))
    return np.asarray(Rotation.align_vectors(axes, normals)[0].as_matrix())


def _shortest(one: Array, other: Array) -> Array:
    """Return the rotation (3, 3) of unit vector `one` to `other` by the shortest way."""
    cross = np.cross(one, other)
    angle = np.arctan2(np.linalg.norm(cross), one @ other)
    return np.asarray(Rotation.from_rotvec(angle * cross / max(float(np.linalg.norm(cross)), 1e-300)).as_matrix())


def normal(field_nT: Array, axis: Array) -> Array:
    """Return the unit normal (3,) of the plane nearest to fields (n, 3), on the side of a nominal axis (3,)."""
    weakest = np.linalg.svd(field_nT - field_nT.mean(axis=0), full_matrices=False)[2][-1]
    return np.asarray(weakest * np.sign(weakest @ axis))


def turns() -> Array:
    """Return the true field (3, n, 3), nT, on a turn about each body axis from level, heading north-east."""
    angles = np.radians(np.arange(0.0, 360.0, STEP_DEG))
    start = Rotation.from_euler("z", 45.0, degrees=True)
    field = spiral(False).field_enu_nT
    about = [start * Rotation.from_rotvec(angles[:, None] * axis) for axis in np.eye(3)]
    return np.array([state_at_attitudes(R.as_matrix(), field).field_nT for R in about])


def axis_trial(seed: int) -> AxisErrors:
    """Search by the swarm, then fit the axes: three turns with the errors of eq. 7, and the AUV's level circles."""
    found = AxisErrors({}, {}, {}, {})
    true_nT, iron = turns(), true_offset_nT(effects())
    noise = NOISE_NT * stream(SEED, seed, "turns").standard_normal(true_nT.shape)
    turned = Turned((true_nT + iron) @ PRINTED_SOFT.T + iron + noise, true_nT, np.eye(3), PRINTED_SOFT @ iron + iron)
    circles = spiral(False)
    up = circles.R_wb[:, 2].mean(axis=0)[None]
    level = Turned(level_nT(seed)[None], circles.field_nT[None], up / np.linalg.norm(up), iron)
    for motion, run in ((TURNS, turned), (CIRCLES, level)):
        _compare(found, motion, run, stream(SEED, seed, "axis", motion))
    return found


def _compare(found: AxisErrors, motion: str, run: Turned, rng: np.random.Generator) -> None:
    """Add the errors of a motion."""
    strength = strength_nT(spiral(False))
    problem = bounded(run.mag_nT.reshape(-1, 3), strength, REACH_NT, WIDTH)
    best = SEARCH.search(problem, rng).best
    centre = problem.middle_nT + strength * best[6:]
    field = (run.mag_nT - centre) @ triangular(best).T
    Q = rotation(np.array([normal(turn, axis) for turn, axis in zip(field, run.axes, strict=True)]), run.axes)
    found.alone_nT[motion] = rms(field - run.true_nT)
    found.fitted_nT[motion] = rms(field @ Q.T - run.true_nT)
    found.angle_deg[motion] = float(np.degrees(Rotation.from_matrix(Q).magnitude()))
    found.offset_nT[motion] = float(np.linalg.norm(centre - run.offset_nT))


def axis_rows(trials: list[AxisErrors]) -> list[PaperRow]:
    """Return a row per motion: component error by the swarm alone and with the axis fit."""
    notes = (
        "an AUV cannot turn so; a hand or a turntable can. Errors of eq. 7, hard iron of the scenario, "
        f"noise {NOISE_NT:g} nT an axis",
        "one axis gives two of the three angles, and the vertical offset, which level circles leave free, none: "
        "what the swarm misses is no rotation",
    )
    return [_row(trials, motion, note) for motion, note in zip((TURNS, CIRCLES), notes, strict=True)]


def _row(trials: list[AxisErrors], motion: str, note: str) -> PaperRow:
    alone, fitted, angle, offset = (
        spread_text([getattr(t, name)[motion] for t in trials])
        for name in ("alone_nT", "fitted_nT", "angle_deg", "offset_nT")
    )
    return PaperRow(
        f"swarm with rotation-axis fit, {motion}: rms error of the components, nT",
        "referred to, no figure",
        f"{fitted} with the fit, {alone} without",
        incomparable("the paper names the method and prints no figure of it"),
        f"the fit turns by {angle} degrees; hard iron wrong by {offset} nT. {note}",
    )
