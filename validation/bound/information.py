"""Fisher information of a calibration for a known field strength, with or without gyro, or a known field vector.

Parameters are in nT: the offset b, and the entries of S times the field's strength.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib.models.linked import tangents
from calib.numerics.chain import chained
from calib.numerics.points import cross_matrices
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.bound.colour import whitened
from validation.bound.experiment import Experiment

AXES = "xyz"
OFFSET = tuple(f"offset_{axis}" for axis in AXES)
SYMMETRIC = tuple((i, j) for i in range(3) for j in range(i, 3))
FULL = tuple((i, j) for i in range(3) for j in range(3))
Places = tuple[tuple[int, int], ...]
Rows = Callable[[Array, Array], Array]
SINGULAR = 1e-11
"""Eigenvalue over the largest, with scaled parameters, below which a direction is unobservable: rounding."""
INVOLVED = 1e-4
"""Share of a figure in unobservable directions above which the figure is unobservable."""
BIAS = 3
"""Components of the gyro's bias."""


@dataclass(frozen=True, eq=False)
class Information:
    """Fisher information (k, k), 1/nT^2, of offset and matrix entries at `places` (i, j).

    eddy_std_s : (3, 3), standard deviation of the eddy term's entries, where the term is estimated too
    """

    matrix: Array
    places: Places
    eddy_std_s: Array | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the parameters: offset_x, ..., S_xx, ..."""
        return (*OFFSET, *(f"S_{AXES[i]}{AXES[j]}" for i, j in self.places))

    @property
    def includes_rotation(self) -> bool:
        """Return whether the rotation of S is estimated, which the field's strength does not determine."""
        return self.places == FULL


def vector(known: Experiment) -> Information:
    """Return ``sum_i J_i^T J_i / sigma^2`` for known field vector and attitude: twelve parameters."""
    return _summed(known, vector_rows, FULL)


def norm(known: Experiment) -> Information:
    """Return the information for a known strength: nine parameters, S symmetric, directions as nuisance parameters."""
    return _summed(known, norm_rows, SYMMETRIC)


def directed(known: Experiment) -> Information:
    """Return the information for known field vector and attitude, S symmetric: an upper limit for any gyro."""
    return _summed(known, directed_rows, SYMMETRIC)


def vector_rows(h: Array, matrix: Array) -> Array:
    """Return J (n, 3, 12) of fields h (n, 3), in units of the strength."""
    return jacobian(h, FULL)


def directed_rows(h: Array, matrix: Array) -> Array:
    """Return J (n, 3, 9) of fields h (n, 3), in units of the strength, for known directions and symmetric S."""
    return jacobian(h, SYMMETRIC)


def norm_rows(h: Array, matrix: Array) -> Array:
    """Return n J (n, 1, 9) of fields h (n, 3), in units of the strength, for a sensor S (3, 3).

    An unknown direction moves S h in the plane S T, T tangent to the sphere; a sample gives only the component along
    the normal of the plane, S^-T h.
    """
    normal = h @ np.linalg.inv(matrix)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.asarray(np.einsum("ni,nij->nj", normal, jacobian(h, SYMMETRIC))[:, None, :])


def _summed(
    known: Experiment, rows: Callable[[Array, Array], Array], places: tuple[tuple[int, int], ...]
) -> Information:
    return Information(_square(known, rows(known.field_nT / known.strength_nT, known.matrix)), places)


def _square(known: Experiment, rows: Array) -> Array:
    """Return the sum of squares (k, k) of rows (n, r, k) divided by white or coloured noise."""
    flat = whitened(rows, known.noise_std_nT, known.colour, known.step_s)
    return np.asarray(flat.T @ flat)


def vector_and_eddy(known: Experiment) -> Information:
    """Return the information as `vector` with nine unknown entries of an eddy term B dh/dt: 21 parameters.

    Raises InputError for a recording without turns.
    """
    rate = known.field_rate_nT_s
    if rate is None:
        what = "the rate of the field is unknown without gyro and attitude"
        raise InputError(what, where="--knowledge vector+eddy", do="map a gyro, or ask with --knowledge vector")
    size = float(np.sqrt(np.mean(np.sum(rate**2, axis=1)))) or 1.0
    eddy = jacobian(rate / size, FULL)[:, :, 3:]
    square = _square(
        known, np.concatenate([vector_rows(known.field_nT / known.strength_nT, known.matrix), eddy], axis=2)
    )
    apart = np.roll(square, len(FULL), axis=(0, 1))
    values, axes = np.linalg.eigh(without_last(apart, 3 + len(FULL)))
    observed = values > SINGULAR * values[-1]
    variance = np.sum(axes[:, observed] ** 2 / values[observed], axis=1)
    lost = np.sum(axes[:, ~observed] ** 2, axis=1) > INVOLVED
    std = np.sqrt(np.where(lost, np.inf, variance)) / size
    left = _cleared(without_last(square, len(FULL)), np.sqrt(np.diag(square)[: 3 + len(FULL)]))
    return Information(left, FULL, std.reshape(3, 3))


def _cleared(information: Array, size: Array) -> Array:
    """Return information (k, k) without rounding errors; size (k,) of the parameters before elimination of others."""
    values, axes = np.linalg.eigh(information / np.outer(size, size))
    root = axes * np.sqrt(np.where(values > SINGULAR, values, 0.0)) * size[:, None]
    root[np.sum(root**2, axis=1) < SINGULAR * size**2] = 0.0
    return np.asarray(root @ root.T)


def norm_and_gyro(known: Experiment) -> Information:
    """Return the information for a known strength, and directions linked by a gyro with unknown bias and white noise.

    u_(i+1) = turn_i u_i + (bias + w_i) step x u,  with two coordinates of u a sample in the tangent plane.
    Raises InputError for a recording without turns, and for coloured noise.
    """
    if known.turns is None:
        what = "there is neither gyro nor attitude to link the samples"
        raise InputError(what, where="--knowledge norm+gyro", do="map a gyro, or ask with --knowledge norm")
    only_white(known)
    J = jacobian(known.field_nT / known.strength_nT, SYMMETRIC)
    across, unknown = tangents(known.directions), BIAS if known.gyro_scale_std == 0 else 2 * BIAS
    seen = known.matrix @ across * known.strength_nT / known.noise_std_nT
    wide = np.concatenate([J / known.noise_std_nT, np.zeros((len(J), 3, unknown))], axis=2)
    turns = np.einsum("nai,nab,nbj->nij", across[1:], known.turns, across[:-1], optimize=True)
    drift = np.concatenate([np.zeros((len(turns), 2, J.shape[2])), _drift(known, across, unknown)], axis=2)
    information = chained(seen, wide, turns, drift, known.gyro_std_rad_s * known.step_s)
    if unknown > BIAS:
        scales = slice(-unknown, -BIAS)
        information[scales, scales] += np.eye(BIAS) / known.gyro_scale_std**2
    return Information(without_last(information, unknown), SYMMETRIC)


def only_white(known: Experiment) -> None:
    """Raise InputError for coloured noise."""
    if known.colour is not None:
        what = "the bound with a gyro supports only white noise"
        raise InputError(what, where="--coloured", do="leave it out, or ask with --knowledge norm or vector")


def _drift(known: Experiment, across: Array, unknown: int) -> Array:
    """Return the rotation (n - 1, 2, unknown) of each step by the gyro's unknown scales, if any, and bias."""
    turned = np.einsum("nai,nab->nib", across[1:], cross_matrices(known.directions[1:]), optimize=True)
    by_bias = known.step_s[:, None, None] * turned
    if unknown == BIAS:
        return np.asarray(by_bias)
    assert known.rate_rad_s is not None
    return np.concatenate([known.rate_rad_s[:, None, :] * by_bias, by_bias], axis=2)


SAMPLE: dict[str, Rows] = {"norm": norm_rows, "vector": vector_rows}
"""Rows of one sample, for knowledge without regard to the order of samples."""
AT_MOST: dict[str, Rows] = SAMPLE | {"norm+gyro": directed_rows}
"""Upper limit of the rows of one sample: a perfect gyro and one direction determine all directions."""


def jacobian(h: Array, places: Places) -> Array:
    """Return d m / d p (n, 3, 3 + entries), p in nT, for h (n, 3) the field over the strength.

    An off-diagonal entry of a symmetric S appears on both sides of the diagonal.
    """
    J = np.zeros((len(h), 3, 3 + len(places)))
    J[:, :, :3] = np.eye(3)
    for k, (i, j) in enumerate(places):
        J[:, i, 3 + k] += h[:, j]
        if places is SYMMETRIC and i != j:
            J[:, j, 3 + k] += h[:, i]
    return J


def without_last(information: Array, count: int) -> Array:
    """Return the information with the last `count` parameters unknown: the Schur complement."""
    A, B, D = information[:-count, :-count], information[:-count, -count:], information[-count:, -count:]
    return np.asarray(A - B @ np.linalg.pinv(D, hermitian=True) @ B.T)
