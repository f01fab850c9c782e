"""Structure of a residual that is not white: a function of the direction in the body, of the field, or of the axes.

r_i = |h_i| - F = a_i . n_i:  n_j = F (alpha_j c_j^2 + beta_j c_j^3), c = S u, for a nonlinear characteristic of axis j;
r_i of any direction for a field that changes with time or place;  n slow for drift, currents and moving iron
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.models.characteristic import fold_products
from calib.models.response import strength_columns, strength_rows
from calib.numerics.colour import BLOCKS, LEAST_BLOCK, block_mean_square, inflation
from calib.numerics.flicker import strength_and_axes
from calib.result import Calibration
from scenarios.arrays import Array
from scenarios.text import figure

FOLDS = BLOCKS[0]
"""Blocks of time, each predicted by a characteristic fitted to the remaining blocks."""
TERMS = 6
"""Quadratic and cubic terms of three axes."""
SOUND = 1e-4
"""Ratio of the least to the largest pivot from which on products are solved without a search for open directions."""
SEEN_T = 4.0
"""Student's t of the gains of the blocks from which on a characteristic is seen: 200 simulated logs of white noise on
the whole sphere and parts of it gave at most 1.0, drift and uneven rooms 0, a characteristic of 3 % at least 5."""
MOST_DISTORTION = 0.1
"""Largest distortion, in parts of the field, that is a characteristic: 3 % of cubic terms give 0.04, the currents of a
quadrotor that hardly tilts 3.9, where the few directions cannot tell the terms from an offset."""
MOST_SAMPLES = 20_000
"""Samples, evenly spaced, that a characteristic is fitted to."""
UNEVEN = 1.3
"""Ratio of the evidence for a change of the field to that of the sensor's axes from which on the field is named: rooms
uneven by 0.5 % gave 1.3 to 2.4, flicker noise and drift 0.3 to 1.3."""
TOLD_FRACTION = 0.001
"""An "ok" names structure of this rms, in parts of the field."""
EVEN_DILUTION = float(np.sqrt(3.0))
"""Deviation of the offset, in units of noise / sqrt(n), for directions spread evenly over the sphere."""

StructureKind = Literal["white", "characteristic", "field", "axes"]
CAUSES: dict[StructureKind, str] = {
    "characteristic": "depends on the direction in the body: a nonlinear characteristic of the sensor's axes, or a "
    "saturated axis",
    "field": "changes with time or place and not with the direction: an uneven room, or iron that moves outside",
    "axes": "changes with time along the sensor's axes: drift, flicker noise, currents, or iron that moves "
    "with the body",
}
REMEDIES: dict[StructureKind, str] = {
    "characteristic": "cover the whole sphere evenly, linearise the sensor, or reduce its hard iron",
    "field": "turn in one place, in the open, away from iron",
    "axes": "let the sensor warm up, switch off what draws current, and turn faster",
}


@dataclass(frozen=True, eq=False)
class Structure:
    """What a residual holds beside white noise.

    rms_nT : rms of the structure; residual_nT : of the residual; left_nT : residual (n,) without a characteristic
    inflation : of a covariance claimed for white residuals, by what is left, see `calib.numerics.colour`
    distortion_nT : (n, 3) of a characteristic in the measurements
    """

    kind: StructureKind
    rms_nT: float
    residual_nT: float
    left_nT: Array
    inflation: float
    distortion_nT: Array | None

    @property
    def text(self) -> str:
        """The cause in words."""
        return f"the residual ({figure(self.residual_nT)} nT rms) is not noise, it {CAUSES[self.kind]}"

    @property
    def remedy(self) -> str:
        """What to do about the cause."""
        return REMEDIES[self.kind]


def structure_of(fit: Calibration, field_nT: Array, rows: tuple[Array, Array], strength_nT: float) -> Structure:
    """The structure of a fit's residual, in order of time, from the corrected field (n, 3) and its `strength_rows`."""
    r, a = rows
    distortion_nT, left = _characteristic(fit, field_nT, strength_nT) or (None, r)
    colour = inflation(left)
    rms_nT, residual_nT = _slow_rms(left) if colour > 1.0 else 0.0, float(np.sqrt(r @ r / len(r)))
    kind: StructureKind = "white"
    if distortion_nT is not None:
        kind, rms_nT = "characteristic", float(np.sqrt(np.mean((r - left) ** 2)))
    elif rms_nT > 0.0:
        kind = _slow_kind(r, a)
    return Structure(kind, rms_nT, residual_nT, left, colour, distortion_nT)


def _slow_rms(r: Array) -> float:
    """Rms of the means over the shortest blocks of a residual (n,); zero for few samples."""
    counts = [blocks for blocks in BLOCKS if len(r) // blocks >= LEAST_BLOCK]
    if not counts:
        return 0.0
    return float(np.sqrt(block_mean_square(np.ascontiguousarray(r[:, None]), counts[-1])))


def _slow_kind(r: Array, a: Array) -> StructureKind:
    """Field or axes, by the covariance of samples near in time."""
    strength, axes = strength_and_axes(r, a)
    return "field" if strength > UNEVEN * axes else "axes"


def dilution(fit: Calibration, field_nT: Array, strength_nT: float) -> float:
    """Deviation of the offset in any direction at most, in units of the residual / sqrt(n).

    sqrt(n max eig(A H A^T)) sigma_d / sigma_r,  H = (sum w J J^T)^-1 of the offset,  sigma_d^2 = mean w r^2
    """
    step = max(1, len(field_nT) // MOST_SAMPLES)
    field_nT = field_nT[::step]
    r, _ = strength_rows(fit, field_nT, strength_nT)
    a, J, _ = strength_columns(fit, field_nT, strength_nT)
    weight = 1.0 / np.einsum("ni,ni->n", a, a)
    offset = np.linalg.pinv((J * weight[:, None]).T @ J, hermitian=True)[:3, :3]
    worst = float(np.linalg.eigvalsh(fit.matrix @ offset @ fit.matrix.T)[-1])
    square = float(r @ r)
    return float(np.sqrt(len(r) * worst * (float(weight @ r**2) / square if square > 0 else 1.0)))


def _characteristic(fit: Calibration, field_nT: Array, strength_nT: float) -> tuple[Array, Array] | None:
    """Distortion (n, 3) of the measurements by alpha c^2 + beta c^3 on each axis, nT, and the residual (n,) of a fit
    with the six terms; None where no characteristic is seen.

    Seen : fitted to all blocks of time but one, the six terms predict that one better than offset and S alone.
    """
    step = max(1, len(field_nT) // MOST_SAMPLES)
    if len(field_nT) // step < FOLDS * LEAST_BLOCK or "S_xx" not in fit.covariance_names:
        return None
    size, squares, slopes = _products(fit, np.ascontiguousarray(field_nT[::step]), strength_nT)
    found, gains = _predicted(squares, slopes)
    spread = float(np.std(gains, ddof=1))
    if not np.mean(gains) > SEEN_T * spread / np.sqrt(FOLDS) > 0.0:
        return None
    r, X, c = _columns(fit, field_nT, strength_nT)
    alpha, beta = np.split((found / size)[-TERMS:], 2)
    distortion_nT = np.asarray(alpha * c**2 + beta * c**3)
    if np.abs(distortion_nT).max() > MOST_DISTORTION * strength_nT:
        return None
    return distortion_nT, r - X @ (found / size)


def _columns(fit: Calibration, field_nT: Array, strength_nT: float) -> tuple[Array, Array, Array]:
    """r (n,), the columns of offset, S and the six terms (n, k), and c (n, 3)."""
    r, _ = strength_rows(fit, field_nT, strength_nT)
    fitted_nT = field_nT * (strength_nT / (r + strength_nT))[:, None]  # r itself would enter the columns
    a, J, _ = strength_columns(fit, fitted_nT, strength_nT)
    c = fitted_nT @ _to_axes(fit) / strength_nT
    terms = a * c
    terms *= c
    return r, np.concatenate((J, terms, terms * c), axis=1), c


def _to_axes(fit: Calibration) -> Array:
    """S^T / |S| (3, 3)."""
    S = np.linalg.inv(fit.matrix)
    return np.asarray(S.T / np.linalg.norm(S, 2))


def _products(fit: Calibration, field_nT: Array, strength_nT: float) -> tuple[Array, Array, Array]:
    """Rms (k,) of the columns X, and products (FOLDS, k, k) and (FOLDS, k) of blocks of X / rms and r, over |a|."""
    left, _, right = np.linalg.svd(fit.matrix)
    squares, products = fold_products(field_nT, fit.matrix, left @ right, _to_axes(fit), strength_nT, FOLDS)
    size = np.sqrt(squares / len(field_nT)) + np.finfo(float).tiny
    return size, products[:, :-1, :-1] / np.outer(size, size), products[:, :-1, -1] / size


def _predicted(squares: Array, slopes: Array) -> tuple[Array, Array]:
    """Least squares from products of blocks, and the gain (FOLDS,) of the last TERMS columns in each block held out."""
    base = slopes.shape[1] - TERMS
    square, slope = squares.sum(axis=0), slopes.sum(axis=0)
    rest, pull = square - squares, slope - slopes
    few = np.zeros_like(slopes)
    few[:, :base] = _solved(rest[:, :base, :base], pull[:, :base])
    before, after = (_squares_less_target(squares, slopes, c) for c in (few, _solved(rest, pull)))
    return _solved(square, slope), before - after


def _squares_less_target(squares: Array, slopes: Array, c: Array) -> Array:
    """``|y - X c|^2 - |y|^2`` (f,) of each block, from its products, for coefficients (f, k)."""
    return np.asarray(np.einsum("fi,fij,fj->f", c, squares, c) - 2 * np.einsum("fk,fk->f", c, slopes))


def _solved(square: Array, slope: Array) -> Array:
    """Least-squares coefficients (..., k) from products (..., k, k) and (..., k); undetermined ones are zero."""
    try:
        diagonal = np.diagonal(np.linalg.cholesky(square), axis1=-2, axis2=-1)
    except np.linalg.LinAlgError:
        diagonal = np.zeros((*slope.shape,))
    if (diagonal.min(axis=-1) > SOUND * diagonal.max(axis=-1)).all():
        return np.asarray(np.linalg.solve(square, slope[..., None])[..., 0])
    return np.asarray((np.linalg.pinv(square, rcond=1e-12, hermitian=True) @ slope[..., None])[..., 0])
