"""Hypothesis of the gap: base, effects and a coloured noise model, by least squares and one held-out likelihood."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter, itemgetter

import numpy as np
from numpy.typing import NDArray

from calib.numerics.symmetric import symmetric_inverse
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.noise_model import NoiseModel
from scenarios.arrays import Array

GONE = 1e-10
"""Part of a column's square below which the remainder after projection is rounding."""
SAME_NATS = 0.5
"""Least gain in nats for which the search of the wander's variance goes on."""
FAR_NATS = 200.0
"""Nats below the best noise model at which a pure random walk is discarded without a search of its variance."""
TOGETHER = 60
"""Columns whitened at once: cost, not a decision."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """``y = B beta + E c + r``, r ~ noise model: beta (q, p) or (1, p), c (k,), and log-likelihoods.

    held_out_log_likelihood: of the rows of each fold, with c from the other folds; log_likelihood: of all rows. The
    base is fitted to all rows in either case: beta is a nuisance parameter, and beside slow noise a part of the rows
    does not determine the base.
    """

    noise_model: NoiseModel
    beta: Array
    c: Array
    held_out_log_likelihood: float
    log_likelihood: float

    @classmethod
    def with_noise_model(cls, rows: BinnedRows, columns: Array, noise_model: NoiseModel) -> Hypothesis:
        """Generalised least squares of columns (n, q, k) under a given noise model."""
        stacked = np.concatenate([rows.base, columns, rows.target[:, :, None]], axis=2)
        z, ln_S = noise_model.whitened(rows.row_start_s, rows.count, stacked)
        p = rows.base.shape[2]
        free, through = project_out(z[:, :, :p], z[:, :, p:], common=rows.common)
        held_out, total = held_out_squares(free, rows.fold, rows.policy.folds)
        c, constant = solved(total), ln_S.sum()
        beta = through[:, :, -1] - through[:, :, :-1] @ c
        return cls(noise_model, beta, c, -(constant + held_out) / 2, -(constant + squares_left(total, c)) / 2)

    @classmethod
    def of(cls, rows: BinnedRows, columns: Array, starts: tuple[NoiseModel, ...]) -> Hypothesis:
        """Fit columns (n, q, k) and the likeliest noise model: from several starts, or a random walk of the axes.

        From a single start a slow noise process would absorb a linear drift.
        """
        found = []
        for start in starts:
            first = cls.with_noise_model(rows, columns, start)
            noise_model = NoiseModel.of(rows.bands(first.residual(rows, columns)), rows.policy, rows.output_axes)
            found.append(cls.with_noise_model(rows, columns, noise_model))
        likelihood = attrgetter("log_likelihood")
        best = max(found, key=likelihood)
        if rows.output_axes is None:
            return best
        walk = NoiseModel.of(rows.bands(best.residual(rows, columns)), rows.policy, rows.output_axes, walking=True)
        beside_walk = cls.with_noise_model(rows, columns, walk)
        far_behind = beside_walk.log_likelihood < best.log_likelihood - FAR_NATS
        return best if far_behind else max(best, beside_walk._with_best_wander(rows, columns), key=likelihood)

    def _with_best_wander(self, rows: BinnedRows, columns: Array) -> Hypothesis:
        """The hypothesis with the wander's variance doubled or halved as long as the likelihood grows.

        Iron absorbs the slowest part of a wander that is modulated by the motion: the residual has the spectrum of a
        smaller or faster wander, under which a drift would appear significant.
        """
        now = self
        for factor in (2.0, 0.5):
            while True:
                larger = replace(now.noise_model, turning=factor * now.noise_model.turning)
                then = Hypothesis.with_noise_model(rows, columns, larger)
                if then.log_likelihood < now.log_likelihood + SAME_NATS:
                    break
                now = then
        return now

    def residual(self, rows: BinnedRows, columns: Array) -> Array:
        """Residual (n, q) of base and effects."""
        beta = np.broadcast_to(self.beta, rows.base.shape[1:])
        residual = rows.target - np.einsum("nqp,qp->nq", rows.base, beta)
        return np.asarray(residual - np.einsum("nqk,k->nq", columns, self.c))


def in_sample_gains(
    rows: BinnedRows, accepted_columns: Array, several: Sequence[Array], noise_model: NoiseModel
) -> Array:
    """Nats (m,) that each of m groups of columns (n, q, k) gains in sample beside base and accepted columns."""
    return np.array([explained_nats(N) for N in information_matrices(rows, accepted_columns, several, noise_model)])


def information_matrices(
    rows: BinnedRows, accepted_columns: Array, several: Sequence[Array], noise_model: NoiseModel
) -> list[Array]:
    """Products (k + 1, k + 1) of each of m groups of columns (n, q, k) and, last, of the target, see `remaining`."""
    found, piece = list[Array](), np.cumsum([group.shape[2] for group in several]) // TOGETHER
    for _, part in itertools.groupby(zip(piece, several, strict=True), key=itemgetter(0)):
        groups = [group for _, group in part]
        left = remaining(rows, accepted_columns, np.concatenate(groups, axis=2), noise_model)
        target, at = left[:, :, -1:], 0
        for group in groups:
            own = left[:, :, at : (at := at + group.shape[2])]
            found.append(products(np.concatenate([own, target], axis=2)))
    return found


def remaining(rows: BinnedRows, accepted_columns: Array, columns: Array, noise_model: NoiseModel) -> Array:
    """Whitened columns (n, q, k) and, last, the target, with base and accepted columns projected out."""
    stacked = np.concatenate([rows.base, accepted_columns, columns, rows.target[:, :, None]], axis=2)
    z, _ = noise_model.whitened(rows.row_start_s, rows.count, stacked)
    p, k = rows.base.shape[2], accepted_columns.shape[2]
    free, _ = project_out(z[:, :, :p], z[:, :, p:], common=rows.common)
    if not k:
        return free
    return without_rounding(project_out(free[:, :, :k], free[:, :, k:])[0], free[:, :, k:])


def white_noise_model(q: int) -> NoiseModel:
    """Noise model of q outputs without slow processes."""
    return NoiseModel(np.ones(1), np.ones(q), np.zeros((q, 1)))


def project_out(base: Array, values: Array, *, common: bool = True) -> tuple[Array, Array]:
    """Values (n, q, j) with the base (n, q, p), in any units, projected out, and coefficients (q, p, j) of the base.

    Each output has coefficients of its own; in common, the outputs are further rows, and the coefficients (1, p, j).
    """
    n, q, _ = values.shape
    B, V = (columns.reshape(n * q, 1, columns.shape[2]) if common else columns for columns in (base, values))
    B, V = B.transpose(1, 0, 2), V.transpose(1, 0, 2)
    by_output = B.transpose(0, 2, 1)
    N = by_output @ B
    size = np.sqrt(np.maximum(np.einsum("qpp->qp", N), 1e-300))[:, :, None]
    through = symmetric_inverse(N / size / size.transpose(0, 2, 1), 1e-13) @ (by_output @ V / size) / size
    return (V - B @ through).transpose(1, 0, 2).reshape(values.shape), through


def without_rounding(left: Array, columns: Array) -> Array:
    """Projected columns (n, q, j), 0 where rounding is all that is left of the columns (n, q, j) before."""
    return np.asarray(left * ((left**2).sum(axis=(0, 1)) > GONE * (columns**2).sum(axis=(0, 1))))


def products(columns: Array) -> Array:
    """Products (j, j) of columns (n, q, j), summed over rows and outputs."""
    flat = columns.reshape(-1, columns.shape[2])
    return np.asarray(flat.T @ flat)


def solved(N: Array) -> Array:
    """Least-squares coefficients c (k,) from products (k + 1, k + 1) of columns and, last, the target."""
    size = np.sqrt(np.maximum(np.diag(N)[:-1], 1e-300))
    inverse = symmetric_inverse(N[:-1, :-1] / np.outer(size, size), 1e-9)
    return np.asarray(inverse @ (N[:-1, -1] / size) / size)


def squares_left(N: Array, c: Array) -> float:
    """Sum of squared residuals for coefficients c (k,), from products (k + 1, k + 1)."""
    v = np.append(c, -1.0)
    return float(v @ N @ v)


def explained_nats(N: Array) -> float:
    """Nats that the columns explain of the target in sample, in white noise of variance one."""
    return float(N[-1, -1] - squares_left(N, solved(N))) / 2


def held_out_squares(columns: Array, fold: NDArray[np.int64], folds: int) -> tuple[float, Array]:
    """Squares left of the target, the last of columns (n, q, j), on the folds (n,), each fitted to the other folds.

    With the products (j, j) over all folds.
    """
    each = np.stack([products(columns[fold == k]) for k in range(folds)])
    total = each.sum(axis=0)
    return sum(squares_left(N, solved(total - N)) for N in each), total
