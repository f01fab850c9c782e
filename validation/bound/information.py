"""Fisher information of a calibration by what is known of the field: its strength, the gyro beside it, or all of it.

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
"""Eigenvalue of the information, in units of its largest with every parameter in units of its own, that is rounding:
the motion says nothing in that direction."""
INVOLVED = 1e-4
"""Share of such a direction from which a parameter, or a figure made of several, is part of it."""
BIAS = 3
"""Components of the gyro's bias."""


@dataclass(frozen=True, eq=False)
class Information:
    """Fisher information (k, k), 1/nT^2, of offset and matrix; `places` (i, j) of the matrix's entries.

    eddy_std_s : (3, 3), of the eddy term's entries, where it has to be found too
    """

    matrix: Array
    places: Places
    eddy_std_s: Array | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters: offset_x, ..., S_xx, ..."""
        return (*OFFSET, *(f"S_{AXES[i]}{AXES[j]}" for i, j in self.places))

    @property
    def tells_rotation(self) -> bool:
        """Whether S is told with its rotation, which the field's strength says nothing of."""
        return self.places == FULL


def vector(known: Experiment) -> Information:
    """Field vector and attitude known, twelve parameters: sum_i J_i^T J_i / sigma^2."""
    return _summed(known, vector_rows, FULL)


def norm(known: Experiment) -> Information:
    """Only the strength known, nine parameters, S symmetric: the direction of every sample is a nuisance."""
    return _summed(known, norm_rows, SYMMETRIC)


def directed(known: Experiment) -> Information:
    """Field vector and attitude known and S symmetric: more than any gyro tells beside the strength."""
    return _summed(known, directed_rows, SYMMETRIC)


def vector_rows(h: Array, matrix: Array) -> Array:
    """J (n, 3, 12) of fields h (n, 3), in units of the strength: what a sample tells, over the noise."""
    return jacobian(h, FULL)


def directed_rows(h: Array, matrix: Array) -> Array:
    """J (n, 3, 9) of fields h (n, 3), in units of the strength, their directions known and S symmetric."""
    return jacobian(h, SYMMETRIC)


def norm_rows(h: Array, matrix: Array) -> Array:
    """n J (n, 1, 9) of fields h (n, 3), in units of the strength, seen by S (3, 3).

    A direction moves S h in the plane S T, T tangent to the sphere: what is left of a sample is its component along
    the normal of that plane, S^-T h.
    """
    normal = h @ np.linalg.inv(matrix)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.asarray(np.einsum("ni,nij->nj", normal, jacobian(h, SYMMETRIC))[:, None, :])


def _summed(
    known: Experiment, rows: Callable[[Array, Array], Array], places: tuple[tuple[int, int], ...]
) -> Information:
    return Information(_square(known, rows(known.field_nT / known.strength_nT, known.matrix)), places)


def _square(known: Experiment, rows: Array) -> Array:
    """Sum of squares (k, k) of rows (n, r, k) over the noise, white or coloured."""
    flat = whitened(rows, known.noise_std_nT, known.colour, known.step_s)
    return np.asarray(flat.T @ flat)


def vector_and_eddy(known: Experiment) -> Information:
    """As `vector` where the nine entries of an eddy term B dh/dt have to be found too, in all 21 parameters.

    Raises InputError for a recording without turns.
    """
    rate = known.field_rate_nT_s
    if rate is None:
        what = "no gyro and no attitude tell how fast the field turns"
        raise InputError(what, where="--knowledge vector+eddy", do="map a gyro, or ask with --knowledge vector")
    size = float(np.sqrt(np.mean(np.sum(rate**2, axis=1)))) or 1.0
    eddy = jacobian(rate / size, FULL)[:, :, 3:]
    square = _square(
        known, np.concatenate([vector_rows(known.field_nT / known.strength_nT, known.matrix), eddy], axis=2)
    )
    apart = np.roll(square, len(FULL), axis=(0, 1))
    values, axes = np.linalg.eigh(without_last(apart, 3 + len(FULL)))
    told = values > SINGULAR * values[-1]
    variance = np.sum(axes[:, told] ** 2 / values[told], axis=1)
    lost = np.sum(axes[:, ~told] ** 2, axis=1) > INVOLVED
    std = np.sqrt(np.where(lost, np.inf, variance)) / size
    left = _cleared(without_last(square, len(FULL)), np.sqrt(np.diag(square)[: 3 + len(FULL)]))
    return Information(left, FULL, std.reshape(3, 3))


def _cleared(information: Array, size: Array) -> Array:
    """Information (k, k) without what is rounding where its parameters were of a size (k,) before others went out."""
    values, axes = np.linalg.eigh(information / np.outer(size, size))
    root = axes * np.sqrt(np.where(values > SINGULAR, values, 0.0)) * size[:, None]
    root[np.sum(root**2, axis=1) < SINGULAR * size**2] = 0.0
    return np.asarray(root @ root.T)


def norm_and_gyro(known: Experiment) -> Information:
    """The strength known, and directions carried from sample to sample by a gyro of unknown bias and white noise.

    u_(i+1) = turn_i u_i + (bias + w_i) step x u,  two coordinates of u a sample in the plane across it.
    Raises InputError for a recording without turns, and for coloured noise.
    """
    if known.turns is None:
        what = "no gyro and no attitude carry the field from sample to sample"
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
    """InputError for noise that lasts."""
    if known.colour is not None:
        what = "the bound with a gyro counts white noise alone"
        raise InputError(what, where="--coloured", do="leave it out, or ask with --knowledge norm or vector")


def _drift(known: Experiment, across: Array, unknown: int) -> Array:
    """How the gyro's scales, where they are unknown, and its bias turn each step: (n - 1, 2, unknown)."""
    turned = np.einsum("nai,nab->nib", across[1:], cross_matrices(known.directions[1:]), optimize=True)
    by_bias = known.step_s[:, None, None] * turned
    if unknown == BIAS:
        return np.asarray(by_bias)
    assert known.rate_rad_s is not None
    return np.concatenate([known.rate_rad_s[:, None, :] * by_bias, by_bias], axis=2)


SAMPLE: dict[str, Rows] = {"norm": norm_rows, "vector": vector_rows}
"""What one sample tells, where its order among the others says nothing."""
AT_MOST: dict[str, Rows] = SAMPLE | {"norm+gyro": directed_rows}
"""What one sample tells at most: a gyro without noise and bias, and one direction, would tell the others."""


def jacobian(h: Array, places: Places) -> Array:
    """d m / d p (n, 3, 3 + entries), p in nT, h (n, 3) the field over its strength.

    An entry off the diagonal of a symmetric S stands on both sides.
    """
    J = np.zeros((len(h), 3, 3 + len(places)))
    J[:, :, :3] = np.eye(3)
    for k, (i, j) in enumerate(places):
        J[:, i, 3 + k] += h[:, j]
        if places is SYMMETRIC and i != j:
            J[:, j, 3 + k] += h[:, i]
    return J


def without_last(information: Array, count: int) -> Array:
    """The information on the first parameters when the last `count` are not known: their Schur complement."""
    A, B, D = information[:-count, :-count], information[:-count, -count:], information[-count:, -count:]
    return np.asarray(A - B @ np.linalg.pinv(D, hermitian=True) @ B.T)
