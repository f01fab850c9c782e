"""Hypothesis of the gap: base, effects and a coloured noise model, compared by one likelihood on held-out folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.numerics.symmetric import symmetric_inverse
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.noise_model import NoiseModel
from scenarios.arrays import Array

SAME_NATS = 0.5
"""Least gain in nats for which the search of the wander's variance goes on."""
FAR_NATS = 200.0
"""Nats below the best noise model at which a pure random walk is discarded without a search of its variance."""
GONE = 1e-10
"""Part of a column's square below which the remainder after projection is rounding."""


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
        free, through = _without_base(z, rows)
        products = np.stack([_products(free[rows.fold == fold]) for fold in range(rows.policy.folds)])
        total = products.sum(axis=0)
        held = [_squares(fold_products, _solved(total - fold_products)) for fold_products in products]
        c = _solved(total)
        beta = through[:, :, -1] - through[:, :, :-1] @ c
        constant = ln_S.sum()
        return cls(noise_model, beta, c, -(constant + sum(held)) / 2, -(constant + _squares(total, c)) / 2)

    @classmethod
    def of(cls, rows: BinnedRows, columns: Array, starts: tuple[NoiseModel, ...]) -> Hypothesis:
        """Fit columns (n, q, k) and the likeliest noise model: from several starts, or a random walk of the axes.

        From a single start a slow noise process would absorb a linear drift.
        """
        found = []
        for start in starts:
            first = cls.with_noise_model(rows, columns, start)
            noise_model = NoiseModel.of(first.residual(rows, columns), rows.interval_s, rows.policy, rows.output_axes)
            found.append(cls.with_noise_model(rows, columns, noise_model))
        best = max(found, key=_log_likelihood)
        if rows.output_axes is None:
            return best
        walk = NoiseModel.walking(best.residual(rows, columns), rows.interval_s, rows.policy, rows.output_axes)
        beside_walk = cls.with_noise_model(rows, columns, walk)
        far_behind = beside_walk.log_likelihood < best.log_likelihood - FAR_NATS
        return best if far_behind else max(best, beside_walk._with_best_wander(rows, columns), key=_log_likelihood)

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


def _log_likelihood(one: Hypothesis) -> float:
    return one.log_likelihood


def in_sample_gains(
    rows: BinnedRows, accepted_columns: Array, several: Sequence[Array], noise_model: NoiseModel
) -> Array:
    """Nats (m,) that each of m groups of columns (n, q, k) gains in sample beside base and accepted columns."""
    found = information_matrices(rows, accepted_columns, several, noise_model)
    return np.array([(N[-1, -1] - _squares(N, _solved(N))) / 2 for N in found])


def information_matrices(
    rows: BinnedRows, accepted_columns: Array, several: Sequence[Array], noise_model: NoiseModel
) -> list[Array]:
    """Products (k + 1, k + 1) of each of m groups of whitened columns (n, q, k) and, last, of the target.

    Base and accepted columns are projected out of columns and target.
    """
    stacked = np.concatenate([rows.base, accepted_columns, *several, rows.target[:, :, None]], axis=2)
    z, _ = noise_model.whitened(rows.row_start_s, rows.count, stacked)
    N, k = _products(_without_base(z, rows)[0]), accepted_columns.shape[2]
    remaining = N[k:, k:] - N[k:, :k] @ _taken(N, k)
    some = np.diag(remaining) > GONE * np.diag(N)[k:]
    N = remaining * np.outer(some, some)
    ends = np.cumsum([group.shape[2] for group in several])
    groups = [np.r_[end - group.shape[2] : end, len(N) - 1] for group, end in zip(several, ends, strict=True)]
    return [N[np.ix_(g, g)] for g in groups]


def information_by_part(
    rows: BinnedRows, accepted_columns: Array, columns: Array, noise_model: NoiseModel, parts: int
) -> list[Array]:
    """Products (k + 1, k + 1) as in `information_matrices`, of one group of columns for each part of the rows."""
    stacked = np.concatenate([rows.base, accepted_columns, columns, rows.target[:, :, None]], axis=2)
    z, _ = noise_model.whitened(rows.row_start_s, rows.count, stacked)
    free, k = _without_base(z, rows)[0], accepted_columns.shape[2]
    remaining = free[:, :, k:] - free[:, :, :k] @ _taken(_products(free), k)
    return [_products(part) for part in np.array_split(remaining, parts)]


def _taken(products: Array, k: int) -> Array:
    """Coefficients (k, j - k) of the projection on the first k columns, from products (j, j) in any units."""
    size = np.sqrt(np.maximum(np.diag(products), 1e-300))
    N = products / np.outer(size, size)
    through = symmetric_inverse(N[:k, :k], 1e-12) @ N[:k, k:]
    return np.asarray(through * size[k:] / size[:k, None])


def _without_base(z: Array, rows: BinnedRows) -> tuple[Array, Array]:
    """Columns (n, q, j) with the first p, the base, projected out, and the coefficients (q, p, .) of the projection.

    Each output has coefficients of its own; with shared coefficients the outputs are further rows, and the coefficients
    (1, p, .).
    """
    shape, p = z.shape, rows.base.shape[2]
    z = z.reshape(-1, 1, shape[2]) if rows.common else z
    B, others = z[:, :, :p], z[:, :, p:]
    by_output = B.transpose(1, 2, 0)
    inverse = symmetric_inverse(by_output @ B.transpose(1, 0, 2), 1e-13)
    through = inverse @ (by_output @ others.transpose(1, 0, 2))
    free = others - (B.transpose(1, 0, 2) @ through).transpose(1, 0, 2)
    return free.reshape(*shape[:2], -1), through


def _products(free: Array) -> Array:
    """Products (j, j) of columns (n, q, j), summed over rows and outputs."""
    flat = free.reshape(-1, free.shape[2])
    return np.asarray(flat.T @ flat)


def _solved(products: Array) -> Array:
    """Least-squares coefficients c (k,) from products (k + 1, k + 1) of columns and target."""
    size = np.sqrt(np.maximum(np.diag(products)[:-1], 1e-300))
    inverse = symmetric_inverse(products[:-1, :-1] / np.outer(size, size), 1e-9)
    return np.asarray(inverse @ (products[:-1, -1] / size) / size)


def _squares(products: Array, c: Array) -> float:
    """Sum of squared residuals for coefficients c (k,)."""
    v = np.append(c, -1.0)
    return float(v @ products @ v)


def white_noise_model(q: int) -> NoiseModel:
    """Noise model of q outputs without slow processes."""
    return NoiseModel(np.ones(1), np.ones(q), np.zeros((q, 1)))
