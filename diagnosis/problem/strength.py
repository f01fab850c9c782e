"""Problem of a recording without heading: the strength of the field is compared, with a level the dip as well."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from calib.numerics.rates import body_rate
from diagnosis.policy import Policy
from diagnosis.problem.blocks import largest_excess
from diagnosis.problem.known import Known, Level
from diagnosis.problem.linear import LinearProblem, about_model_effects
from diagnosis.problem.motion import measured, noise_of_neighbours, outliers, state_of
from diagnosis.problem.sensors import measured_strength
from recordings import Recording
from scenarios.arrays import Array
from sim.state import State
from validation.signals.direction_rate import median_rate_rad_s

TURN_STEP_S = 0.04
"""Time step of the turn rate: short beside a wheel's turn, long beside the noise of a hand-held sensor."""
MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and relative change of the cost that ends them: ahead of the valleys that a motion hardly determines.
"""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Damping of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Number of updates of the residual's colour and of the outliers."""
LEAST_NOISE = 1e-6
"""Least noise over the field: with less, nothing is left of the prior in the sums of squares."""
LEAST_LEVEL = 1e-6
"""Horizontal part of a unit direction below which the direction counts as vertical."""
DIP_ERROR_RAD = 0.02
"""Standard deviation of a given field's dip: a prior."""


def strength_problem(recording: Recording, known: Known, disturbance_nT: Array | float = 0.0) -> LinearProblem:
    """The problem of the strength, see `LinearProblem`, with iron fitted after a known disturbance is subtracted.

    With the part d (n, 3) of the measurement m subtracted, ``h = M (m - d - o)`` and ``u = h / |h|``; ``y = |h| - F + u
    M d``, to first order independent of d, so that effects and iron are estimated jointly by iteration. A recorded
    scalar magnetometer, which must be compensated, replaces the given F sample by sample. With a level the dip is
    compared as well: ``F (dip(h) - I) + v M d``, v the direction across u of increasing dip. The model's effects other
    than iron are subtracted from m first.
    """
    F_nT, given_enu_nT, track = measured_strength(recording), known.given_enu_nT, known.track
    if F_nT is None:
        F_nT = np.full((len(recording), 1), known.strength_nT) + (0.0 if track is None else track.change_nT[:, None])
    middle_nT = np.array([0.0, known.strength_nT, 0.0]) if given_enu_nT is None else given_enu_nT
    if track is None:
        middle_nT = middle_nT * (float(np.median(F_nT)) / known.strength_nT)
    return about_model_effects(partial(_about_iron, recording, F_nT, middle_nT, disturbance_nT, known))


def _about_iron(
    recording: Recording,
    F_nT: Array,
    middle_nT: Array,
    disturbance_nT: Array | float,
    known: Known,
    beyond_nT: Array | float,
) -> LinearProblem:
    """The problem of strengths (n, 1), in a field (3,) in the middle, iron fitted less disturbance and effects."""
    level, policy = known.level, known.policy
    mag_nT = recording.mag_nT - beyond_nT - disturbance_nT
    iron = fit_iron(mag_nT, F_nT[:, 0], recording.time_s, policy, level)
    output_axes, off_nT = compared(iron.field_nT(mag_nT), F_nT, level)
    off_nT[:, 1:] -= F_nT * np.median(off_nT[:, 1:] / F_nT, axis=0)  # the dip is known but for a constant
    sigma, field_nT = _noise_nT(off_nT, recording, policy), output_axes[:, 0] * F_nT
    off_nT += np.einsum("nqi,ni->nq", output_axes @ iron.matrix, recording.mag_nT - beyond_nT - mag_nT)
    clean_nT = field_nT @ iron.turn.T + iron.offset_nT
    return LinearProblem(
        **vars(known),
        recording=recording,
        state=_state(recording, field_nT, middle_nT, level),
        base=strength_columns(output_axes[:, 0]) if level is None else dip_columns(output_axes) / sigma[:, None],
        target=off_nT / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=iron.turn,
        clean_nT=clean_nT,
        predicted_nT=clean_nT + beyond_nT,
        inputs=measured(recording) | {"rate"},  # of the field that is measured
        output_axes=output_axes,
    )


def _noise_nT(off_nT: Array, seen: Recording, policy: Policy) -> Array:
    """Noise of a sample (q,) of each deviation (n, q)."""
    return np.concatenate([noise_of_neighbours(off[:, None], seen.mag_nT, seen.time_s, policy) for off in off_nT.T])


def strength_columns(direction: Array) -> Array:
    """Derivatives (n, 9) of the strength by a symmetric matrix and an offset, along unit directions (n, 3)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])


def dip_columns(output_axes: Array) -> Array:
    """Derivatives (n, 2, 13) of strength and dip by a matrix, an offset, and a constant error of the given dip.

    output_axes (n, 2, 3): unit directions of the field, and of increasing dip. The outputs share the coefficients.
    """
    n, q, _ = output_axes.shape
    elements = (output_axes[:, :, :, None] * output_axes[:, :1, None, :]).reshape(n, q, 9)
    constant = np.tile([[0.0], [1.0]], (n, 1, 1))
    return np.concatenate([elements, output_axes, constant], axis=2)


def _state(recording: Recording, field_nT: Array, field_enu_nT: Array, level: Level | None) -> State:
    """The state with attitudes that turn a measured field (n, 3) to the given one, and down to down, or anywhere."""
    down, down_enu = (np.eye(3)[np.abs(field).argmin(axis=1)] for field in (field_nT, field_enu_nT[None]))
    if level is not None:
        down, down_enu = level.down, np.array([[0.0, 0.0, -1.0]])
    R_wb = _axes(field_enu_nT[None], down_enu).transpose(0, 2, 1) @ _axes(field_nT, down)
    return state_of(recording, field_enu_nT, field_nT, body_rate(recording), R_wb=R_wb)


def _axes(field: Array, second: Array) -> Array:
    """Right-handed unit vectors (n, 3, 3), as rows: along fields (n, 3), and towards second vectors."""
    first = field / np.linalg.norm(field, axis=1, keepdims=True)
    third = np.cross(first, second)
    third /= np.maximum(np.linalg.norm(third, axis=1, keepdims=True), LEAST_LEVEL)
    return np.stack([first, np.cross(third, first), third], axis=1)


def turn_rate_rad_s(problem: LinearProblem) -> float:
    """Median turn rate of the measured field in sensor axes, over a time step that suppresses noise."""
    u = (problem.recording.mag_nT - problem.beyond_nT - problem.offset_nT) @ np.linalg.inv(problem.turn).T
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return median_rate_rad_s(u, problem.state.time_s, TURN_STEP_S)


def turns_too_fast(problem: LinearProblem) -> bool:
    """Whether the field, assumed constant in a turning sensor without a logged turn, turns faster than any vehicle."""
    unseen = problem.mode == "strength" and problem.recording.gyro_rad_s is None and problem.recording.att_q is None
    return unseen and turn_rate_rad_s(problem) > problem.policy.fastest_turn


class Iron(NamedTuple):
    """``h = M (m - o)``: matrix M (3, 3) and offset o (3,) in nT."""

    matrix: Array
    offset_nT: Array

    def field_nT(self, measured_nT: Array) -> Array:
        """Corrected field (n, 3)."""
        return np.asarray((measured_nT - self.offset_nT) @ self.matrix.T)

    @property
    def turn(self) -> Array:
        """``M^-1`` (3, 3), from the field to the measurement."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)


def fit_iron(measured_nT: Array, strength_nT: Array, time_s: Array, policy: Policy, level: Level | None = None) -> Iron:
    """Iron for measurements m (n, 3) at times (n,) with strength F (n,), and dip I (n,) by a level; without outliers.

    ``min sum (|h| - F)^2 / v + F^2 (dip(h) - I - c)^2 / w + prior``, ``h = M (m - o)``, c a constant error of the given
    dip. Without a level M is symmetric: the strength shows no turn. v and w are the power of a residual times its
    colour over means of `block_s` and more, so that a slow disturbance does not bend axes that the motion hardly
    determines. In unobservable directions the prior holds, M = 1 and o = 0.
    """
    unit, middle_nT = unit_of(measured_nT, strength_nT, policy)
    y, F, p = measured_nT * (unit / middle_nT), strength_nT / middle_nT, 12 if level is None else 13
    mean = np.r_[np.eye(3).ravel(), np.zeros(4)][:p]
    std = np.repeat([policy.matrix_prior, policy.offset_prior, DIP_ERROR_RAD], [9, 3, 1])[:p]
    theta, block = mean, max(1, round(policy.block_s / float(np.median(np.diff(time_s)))))
    for _ in range(ROUNDS):
        off = deviations(theta, y, F, level)[0]
        weight = np.column_stack([_weight(column, block, policy) for column in off.T])
        theta = _least(theta, y, F, level, weight, mean, std)
    matrix = theta[:9].reshape(3, 3)
    if level is None:
        _, size, axes = np.linalg.svd(matrix)
        matrix = (axes.T * size) @ axes
    return Iron(matrix * unit, theta[9:12] * middle_nT / unit)


def unit_of(measured_nT: Array, strength_nT: Array, policy: Policy) -> tuple[float, float]:
    """Factor from the unit of measurements (n, 3) to the unit of strengths (n,), and the median strength."""
    size, middle_nT = (float(np.median(sizes)) for sizes in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    return 1.0 if 1 / policy.clearly_larger < size / middle_nT < policy.clearly_larger else middle_nT / size, middle_nT


def _least(theta: Array, y: Array, F: Array, level: Level | None, weight: Array, mean: Array, std: Array) -> Array:
    """Parameters (p,) by Levenberg-Marquardt steps: least squares of `deviations` with weights (n, q), and a prior."""

    def normal(theta: Array) -> tuple[float, Array, Array]:
        off, J = deviations(theta, y, F, level)
        weighted = (J * weight[:, :, None]).reshape(-1, len(theta))
        from_mean = (theta - mean) / std
        cost = float((weight * off**2).sum() + from_mean @ from_mean)
        square = weighted.T @ J.reshape(weighted.shape) + np.diag(std**-2.0)
        return cost, weighted.T @ off.ravel() + from_mean / std, square

    damping, (now, slope, square) = FIRST_DAMPING, normal(theta)
    for _ in range(MOST_STEPS):
        further = theta - np.linalg.solve(square + damping * np.diag(np.diag(square)), slope)
        then, *equations = normal(further)
        if then > now:
            damping *= DAMPING_FACTOR
            continue
        settled = now - then < SETTLED * now
        theta, now, (slope, square), damping = further, then, equations, damping / DAMPING_FACTOR
        if settled:
            break
    return theta


def deviations(theta: Array, y: Array, F: Array, level: Level | None) -> tuple[Array, Array]:
    """``|h| - F`` and ``F (dip(h) - I - c)`` of ``h = M (y - o)``, in units of the field: (n, q), and slopes (n, q, p).

    Parameters theta (p,): nine elements of M, three of o, and c with a level.
    """
    matrix, from_offset = theta[:9].reshape(3, 3), y - theta[9:12]
    h = from_offset @ matrix.T
    along, off = compared(h, F[:, None], level)
    slopes = np.zeros((*off.shape, len(theta)))
    if level is not None:
        off[:, 1] -= F * theta[12]
        along[:, 1] *= (F / np.linalg.norm(h, axis=1))[:, None]
        slopes[:, 1, 12] = -F
    slopes[:, :, :9] = (along[:, :, :, None] * from_offset[:, None, None, :]).reshape(*off.shape, 9)
    slopes[:, :, 9:12] = -along @ matrix
    return off, slopes


def compared(field: Array, F: Array, level: Level | None) -> tuple[Array, Array]:
    """Directions (n, q, 3) of strength and dip of a field (n, 3), and their deviations (n, q) from those given.

    F (n, 1): strength in the field's unit; the dip's deviation is an angle times the strength.
    """
    size = np.linalg.norm(field, axis=1, keepdims=True)
    direction = field / np.maximum(size, LEAST_LEVEL * F)
    if level is None:
        return direction[:, None], size - F
    off = np.column_stack([size - F, F[:, 0] * (dip_rad(field, level.down) - level.dip_rad)])
    return np.stack([direction, upright(direction, level.down)], axis=1), off


def dip_rad(field: Array, down: Array) -> Array:
    """Angle (n,) of fields (n, 3) below the horizontal, with unit vectors down (n, 3)."""
    along = np.einsum("ni,ni->n", field, down)
    return np.asarray(np.arctan2(along, np.linalg.norm(field - along[:, None] * down, axis=1)))


def upright(direction: Array, down: Array) -> Array:
    """Unit vectors (n, 3) of increasing dip: across directions (n, 3), in the vertical plane, towards down."""
    across = down - np.einsum("ni,ni->n", direction, down)[:, None] * direction
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_LEVEL))


def _weight(off: Array, block: int, policy: Policy) -> Array:
    """Weights (n,) of deviations (n,): 0 for outliers, else 1 over the power and its colour, by blocks of samples."""
    near = ~outliers(off[:, None], policy)
    power = max(float((off[near] ** 2).mean()), LEAST_NOISE**2)
    m = np.count_nonzero(near) // block
    total = off[near][: m * block].reshape(m, block, 1).sum(axis=1) / np.sqrt(power)
    return np.asarray(near / (power * largest_excess(total, np.full(m, float(block)), policy)))
