"""The limit that tilts set to any motion: the best of all ways to spend the samples on attitudes within them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.bound.experiment import Experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.information import AT_MOST, SINGULAR

YAW_STEP_DEG = 5.0
"""Of the attitudes that a design is made of; at half the step the limits of the standard case change by under 0.1 %."""
TILT_STEP_DEG = 10.0
UPRIGHT_DEG, HALF_TURN_DEG = 90.0, 180.0
LEAST_TILTS = 9
"""Tilts about each axis, however narrow the limits."""
GAP = 1e-3
"""The design is done when no other can be better by more than this share."""
MOST_ROUNDS = 10_000
BETWEEN = 25
"""Rounds among the candidates with weight between two looks at all."""
RARE = 1e-7
"""Weight, in units of the largest, of a candidate that waits for such a look."""


@dataclass(frozen=True)
class Tilts:
    """|roll| and |pitch| stay within these, degrees; yaw is free."""

    roll_deg: float
    pitch_deg: float

    @classmethod
    def parsed(cls, text: str, where: str) -> Tilts:
        """Read "ROLL,PITCH"; InputError for anything else, and beyond 180 and 90 degrees."""
        try:
            roll, pitch = (float(part) for part in text.split(","))
        except ValueError:
            roll = pitch = np.nan
        return cls.checked(roll, pitch, where)

    @classmethod
    def checked(cls, roll: float, pitch: float, where: str) -> Tilts:
        """Of numbers; InputError for what is none, and beyond 180 and 90 degrees."""
        if not (0 <= roll <= 180 and 0 <= pitch <= 90):
            do = "give roll up to 180 and pitch up to 90 degrees, as in 5,45"
            raise InputError(f"{roll:g},{pitch:g} is no pair of tilts", where=where, do=do)
        return cls(roll, pitch)

    @classmethod
    def of(cls, attitudes: Rotation) -> Tilts:
        """The least that hold these attitudes."""
        pitch, roll = tilts_deg(attitudes).max(axis=0)
        return cls(float(roll), float(pitch))

    def angles_deg(self, step_deg: float | None = None) -> Array:
        """Yaw, pitch, roll (m, 3) of a grid over all that they allow.

        step_deg : whole multiples of so much alone, as a person can show them, and none with the nose straight up or
        down, where yaw and roll are one.
        """
        if step_deg is None:
            pitch, roll = _grid(self.pitch_deg), _grid(self.roll_deg)
        else:
            pitch, roll = _multiples(step_deg, self.pitch_deg), _multiples(step_deg, self.roll_deg)
            pitch, roll = pitch[np.abs(pitch) < UPRIGHT_DEG], roll[roll > -HALF_TURN_DEG]
        yaw = np.arange(0.0, 360.0, step_deg or YAW_STEP_DEG)
        return np.reshape(np.meshgrid(yaw, pitch, roll, indexing="ij"), (3, -1)).T

    def attitudes(self) -> Rotation:
        """The grid as rotations."""
        return Rotation.from_euler("ZYX", self.angles_deg(), degrees=True)


@dataclass(frozen=True, eq=False)
class Limit:
    """The least error within tilts, of the goal's unit, and by how much of it, at most, the design misses the best.

    attitudes (m), weights (m,) : the design, share of the samples each; infinite where the tilts do not tell it.
    """

    tilts: Tilts
    goal: Goal
    value: float
    gap: float
    attitudes: Rotation
    weights: Array


def limit(known: Experiment, knowledge: str, tilts: Tilts, goal: Goal = OFFSET, before: Array | None = None) -> Limit:
    """A-optimal design for a goal B: min_w tr B^T (sum_k w_k I_k)^-1 B, w >= 0, sum w = 1; B the offset's block.

    before : information (k, k) that there is already beside the samples'

    I_k is the information of a sample at attitude k, with a gyro at most (AT_MOST): no motion is below that limit, and
    none reaches it. For so many samples and the noise of the experiment, whichever way
    it moved. Raises InputError where the field's vector is not known, or the knowledge depends on the samples' order.
    """
    attitudes, rows = candidates(known, knowledge, tilts)
    variance, gap, weights = optimal(rows, goal.factor(known, knowledge), before)
    return Limit(tilts, goal, float(np.sqrt(variance)), gap, attitudes, weights)


def candidates(known: Experiment, knowledge: str, tilts: Tilts) -> tuple[Rotation, Array]:
    """Attitudes (m) of the tilts' grid, and what a sample at each tells, were it all of them: rows (m, r, k).

    Raises InputError as `limit` does.
    """
    if known.field_enu_nT is None:
        raise InputError("the field's direction is not known", where="--tilt-limits", do="give --field-enu-nT E,N,U")
    if knowledge not in AT_MOST:
        what = f"what {knowledge} tells depends on the order of the samples, and a limit over attitudes has none"
        raise InputError(what, where="--tilt-limits", do=f"ask with --knowledge {' or '.join(AT_MOST)}")
    if known.colour is not None:
        what = "noise that lasts makes the order of the samples count, and a limit over attitudes has none"
        raise InputError(what, where="--tilt-limits", do="leave --coloured out")
    attitudes = tilts.attitudes()
    return attitudes, sample_rows(known, knowledge, attitudes) * np.sqrt(len(known.field_nT))


def sample_rows(known: Experiment, knowledge: str, attitudes: Rotation) -> Array:
    """What a sample at each attitude tells, over the noise: rows (m, r, k), 1/nT, whose squares are its information."""
    assert known.field_enu_nT is not None
    field = attitudes.inv().apply(known.field_enu_nT) / known.strength_nT
    return AT_MOST[knowledge](field, known.matrix) / known.noise_std_nT


def optimal(rows: Array, wanted: Array, before: Array | None = None) -> tuple[float, float, Array]:
    """Weights (m,) of candidates with rows (m, r, k) that minimise f = tr B^T M^-1 B, B (k, q) what is wanted.

    M = before + sum_k w_k I_k. With d_k = tr B^T M^-1 I_k M^-1 B the weights become w_k sqrt(d_k), normalised
    [Yu2010]; no design is below f^2 / (f + max_k d_k - sum_k w_k d_k). Returns f, the gap of sqrt f, and w; f is
    infinite where M is singular.
    """
    weights, variance, gap = np.full(len(rows), 1.0 / len(rows)), np.inf, 0.0
    for _ in range(MOST_ROUNDS // BETWEEN):
        variance, slope = felt(rows, weights, wanted, before)
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
    """Weights after some rounds among the candidates that matter."""
    total = weights.sum()
    for _ in range(BETWEEN):
        weights = total * _moved(weights, felt(rows, weights, wanted, before)[1])
    return weights


def _moved(weights: Array, slope: Array) -> Array:
    moved = weights * np.sqrt(slope)
    return np.asarray(moved / moved.sum())


def felt(rows: Array, weights: Array, wanted: Array, before: Array | None) -> tuple[float, Array]:
    """f and the d_k (m,) of weights; infinite and nothing where M is singular."""
    spread = (rows * weights[:, None, None]).reshape(-1, rows.shape[2])
    told = spread.T @ rows.reshape(-1, rows.shape[2])
    covariance = inverse(told if before is None else before + told)
    if covariance is None:
        return np.inf, np.ones(len(rows))
    felt = covariance @ wanted
    return float(np.sum(wanted * felt)), np.asarray(np.sum((rows @ felt) ** 2, axis=(1, 2)))


def inverse(information: Array) -> Array | None:
    """The inverse, every parameter scaled to one first; None where it is singular."""
    size = np.sqrt(np.diag(information))
    if not (size > 0).all():
        return None
    scaled = information / np.outer(size, size)
    if np.linalg.eigvalsh(scaled)[0] < SINGULAR:
        return None
    return np.asarray(np.linalg.inv(scaled) / np.outer(size, size))


def tilts_deg(attitudes: Rotation) -> Array:
    """|pitch| and |roll| (n, 2)."""
    down = attitudes.as_matrix()[:, 2]
    pitch, roll = np.arcsin(np.clip(down[:, 0], -1.0, 1.0)), np.arctan2(down[:, 1], down[:, 2])
    return np.asarray(np.degrees(np.abs(np.column_stack([pitch, roll]))))


def _multiples(step_deg: float, most_deg: float) -> Array:
    return step_deg * np.arange(-(most_deg // step_deg), most_deg // step_deg + 1)


def _grid(most_deg: float) -> Array:
    count = max(LEAST_TILTS, 2 * int(np.ceil(most_deg / TILT_STEP_DEG)) + 1)
    return np.unique(np.linspace(-most_deg, most_deg, count))
