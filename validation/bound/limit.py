"""Limit of any motion within tilts: the optimal distribution of samples over attitudes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.bound.experiment import Experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.information import AT_MOST, SINGULAR
from validation.text import figure

YAW_STEP_DEG = 5.0
"""Yaw step of a design's attitudes; half the step changes limits of the standard case by less than 0.1 %."""
TILT_STEP_DEG = 10.0
UPRIGHT_DEG, HALF_TURN_DEG = 90.0, 180.0
LEAST_TILTS = 9
"""Tilts about each axis, however narrow the limits."""
GAP = 1e-3
"""Relative duality gap at which a design is optimal."""
SHOWN_GAP = 1e-4
"""Least relative duality gap that is told by a figure."""
MOST_ROUNDS = 10_000
BETWEEN = 25
"""Rounds over candidates with weight, between two rounds over all candidates."""
RARE = 1e-7
"""Weight over the largest below which a candidate is left to rounds over all."""


@dataclass(frozen=True)
class Tilts:
    """Limits of |roll| and |pitch| in degrees; yaw is free."""

    roll_deg: float
    pitch_deg: float

    @classmethod
    def parsed(cls, text: str, where: str) -> Tilts:
        """Read "ROLL,PITCH"; InputError for other texts, and beyond 180 and 90 degrees."""
        try:
            roll, pitch = (float(part) for part in text.split(","))
        except ValueError:
            roll = pitch = np.nan
        return cls.checked(roll, pitch, where)

    @classmethod
    def checked(cls, roll: float, pitch: float, where: str) -> Tilts:
        """Return tilts from numbers; InputError for NaN, and beyond 180 and 90 degrees."""
        if not (0 <= roll <= 180 and 0 <= pitch <= 90):
            do = "give roll up to 180 and pitch up to 90 degrees, as in 5,45"
            raise InputError(f"{roll:g},{pitch:g} is no pair of tilts", where=where, do=do)
        return cls(roll, pitch)

    @classmethod
    def of(cls, attitudes: Rotation) -> Tilts:
        """Return the smallest limits that contain all attitudes."""
        pitch, roll = tilts_deg(attitudes).max(axis=0)
        return cls(float(roll), float(pitch))

    def angles_deg(self, step_deg: float | None = None) -> Array:
        """Return yaw, pitch, roll (m, 3) of a grid over all attitudes within the limits.

        step_deg : only whole multiples, for flights by hand; without nose straight up or down, where yaw and roll
        coincide.
        """
        if step_deg is None:
            pitch, roll = _grid(self.pitch_deg), _grid(self.roll_deg)
        else:
            pitch, roll = _multiples(step_deg, self.pitch_deg), _multiples(step_deg, self.roll_deg)
            pitch, roll = pitch[np.abs(pitch) < UPRIGHT_DEG], roll[roll > -HALF_TURN_DEG]
        yaw = np.arange(0.0, 360.0, step_deg or YAW_STEP_DEG)
        return np.reshape(np.meshgrid(yaw, pitch, roll, indexing="ij"), (3, -1)).T

    def attitudes(self) -> Rotation:
        """Return the grid as rotations."""
        return Rotation.from_euler("ZYX", self.angles_deg(), degrees=True)


@dataclass(frozen=True, eq=False)
class Limit:
    """Least error within tilts, in the goal's unit, infinite if unobservable; and the relative gap to the optimum.

    attitudes (m), weights (m,) : the design, with the share of the samples of each attitude.
    """

    tilts: Tilts
    goal: Goal
    value: float
    gap: float
    attitudes: Rotation
    weights: Array

    @property
    def gap_words(self) -> str:
        """The gap in per cent: what is smaller than 0.01 % is no more than that."""
        return f"duality gap {figure(100 * self.gap, 2)} %" if self.gap >= SHOWN_GAP else "duality gap below 0.01 %"


def limit(known: Experiment, knowledge: str, tilts: Tilts, goal: Goal = OFFSET, before: Array | None = None) -> Limit:
    """Return the A-optimal design for a goal B: min_w tr B^T (sum_k w_k I_k)^-1 B, w >= 0, sum w = 1.

    before : information (k, k) from earlier samples.
    I_k is the information of a sample at attitude k, with a gyro an upper limit (AT_MOST): no motion is better. The
    experiment gives number of samples and noise; the motion does not matter.
    Raises InputError without the field's vector, and for knowledge that depends on the order of the samples.
    """
    attitudes, rows = candidates(known, knowledge, tilts)
    variance, gap, weights = optimal(rows, goal.factor(known, knowledge), before)
    return Limit(tilts, goal, float(np.sqrt(variance)), gap, attitudes, weights)


def candidates(known: Experiment, knowledge: str, tilts: Tilts) -> tuple[Rotation, Array]:
    """Return attitudes (m) of the tilts' grid, and rows (m, r, k) for all samples at one attitude.

    Raises InputError as `limit` does.
    """
    if known.field_enu_nT is None:
        raise InputError("the field's direction is not known", where="--tilt-limits", do="give --field-enu-nT E,N,U")
    if knowledge not in AT_MOST:
        what = f"information by {knowledge} depends on the order of the samples, which a limit over attitudes ignores"
        raise InputError(what, where="--tilt-limits", do=f"ask with --knowledge {' or '.join(AT_MOST)}")
    if known.colour is not None:
        what = "with coloured noise the order of the samples matters, which a limit over attitudes ignores"
        raise InputError(what, where="--tilt-limits", do="leave --coloured out")
    attitudes = tilts.attitudes()
    return attitudes, sample_rows(known, knowledge, attitudes) * np.sqrt(len(known.field_nT))


def sample_rows(known: Experiment, knowledge: str, attitudes: Rotation) -> Array:
    """Return rows (m, r, k) in 1/nT of a sample at each attitude; squares of rows are the information."""
    assert known.field_enu_nT is not None
    field = attitudes.inv().apply(known.field_enu_nT) / known.strength_nT
    return AT_MOST[knowledge](field, known.matrix) / known.noise_std_nT


def optimal(rows: Array, wanted: Array, before: Array | None = None) -> tuple[float, float, Array]:
    """Return weights (m,) of candidates with rows (m, r, k) that minimise ``f = tr B^T M^-1 B``, B (k, q) `wanted`.

    M = before + sum_k w_k I_k. With d_k = tr B^T M^-1 I_k M^-1 B the weights become w_k sqrt(d_k), normalised
    [Yu2010]; no design is below f^2 / (f + max_k d_k - sum_k w_k d_k). Returns f, the gap of sqrt f, and w; f is
    infinite for singular M.
    """
    weights, variance, gap = np.full(len(rows), 1.0 / len(rows)), np.inf, 0.0
    for _ in range(MOST_ROUNDS // BETWEEN):
        variance, slope = criterion(rows, weights, wanted, before)
        if not np.isfinite(variance):
            return np.inf, 0.0, weights
        gap = max(1.0 - float(np.sqrt(variance / (variance + slope.max() - weights @ slope))), 0.0)
        if gap < GAP:
            break
        weights = _moved(weights, slope)
        main = np.flatnonzero(weights > RARE * weights.max())
        weights[main] = _settled(rows[main], weights[main], wanted, before)
        weights /= weights.sum()
    return variance, gap, weights


def _settled(rows: Array, weights: Array, wanted: Array, before: Array | None) -> Array:
    """Return weights after BETWEEN rounds over the given candidates."""
    total = weights.sum()
    for _ in range(BETWEEN):
        weights = total * _moved(weights, criterion(rows, weights, wanted, before)[1])
    return weights


def _moved(weights: Array, slope: Array) -> Array:
    moved = weights * np.sqrt(slope)
    return np.asarray(moved / moved.sum())


def criterion(rows: Array, weights: Array, wanted: Array, before: Array | None) -> tuple[float, Array]:
    """Return f and d_k (m,) of weights; infinity and ones for singular M."""
    flat = rows.reshape(-1, rows.shape[2])
    information = (flat * np.repeat(weights, rows.shape[1])[:, None]).T @ flat
    covariance = inverse(information if before is None else before + information)
    if covariance is None:
        return np.inf, np.ones(len(rows))
    sensitivity = covariance @ wanted
    seen = (flat @ sensitivity).reshape(len(rows), -1)
    return float(np.vdot(wanted, sensitivity)), np.einsum("mr,mr->m", seen, seen)


def inverse(information: Array) -> Array | None:
    """Return the inverse, computed with scaled parameters; None for a singular matrix."""
    size = np.sqrt(np.diag(information))
    if not (size > 0).all():
        return None
    w, V = np.linalg.eigh(information / (size[:, None] * size))
    if w[0] < SINGULAR:
        return None
    axes = V / size[:, None]
    return np.asarray((axes / w) @ axes.T)


def tilts_deg(attitudes: Rotation) -> Array:
    """Return |pitch| and |roll| (n, 2)."""
    down = attitudes.as_matrix()[:, 2]
    pitch, roll = np.arcsin(np.clip(down[:, 0], -1.0, 1.0)), np.arctan2(down[:, 1], down[:, 2])
    return np.asarray(np.degrees(np.abs(np.column_stack([pitch, roll]))))


def _multiples(step_deg: float, most_deg: float) -> Array:
    return step_deg * np.arange(-(most_deg // step_deg), most_deg // step_deg + 1)


def _grid(most_deg: float) -> Array:
    count = max(LEAST_TILTS, 2 * int(np.ceil(most_deg / TILT_STEP_DEG)) + 1)
    return np.unique(np.linspace(-most_deg, most_deg, count))
