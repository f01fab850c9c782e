"""A hypothesis of the gap: iron, effects, and a rest with its own colour; one likelihood for all, on held-out folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.noise_model import NoiseModel
from scenarios.arrays import Array

SAME_NATS = 0.5
"""Nats by which a walk of another size must be likelier to go on from it."""
FAR_NATS = 200.0
"""Nats by which a walk is behind at first so far that no size of it is asked."""
GONE = 1e-10
"""Part of a column's square below which it is the rounding of what other columns make whole."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """``y = B beta + E c + rest`` on rows: the rest, beta (q, p) or (1, p) of all outputs, c (k,), and log-likelihoods.

    held: of the rows that each fold holds out, with c of the others; whole: of all rows. The base is fitted to all rows
    in both: it is not what is asked, and beside a slow rest a part of them does not determine it.
    """

    rest: NoiseModel
    beta: Array
    c: Array
    held: float
    whole: float

    @classmethod
    def given(cls, rows: BinnedRows, columns: Array, rest: NoiseModel) -> Hypothesis:
        """The hypothesis with columns (n, q, k) and a rest that is known: generalised least squares."""
        stacked = np.concatenate([rows.base, columns, rows.target[:, :, None]], axis=2)
        z, ln_S = rest.whitened(rows.row_s, rows.count, stacked)
        free, through = _without_base(z, rows)
        products = np.stack([_products(free[rows.fold == fold]) for fold in range(rows.policy.folds)])
        total = products.sum(axis=0)
        held = [_squares(one, _solved(total - one)) for one in products]
        c = _solved(total)
        beta = through[:, :, -1] - through[:, :, :-1] @ c
        constant = ln_S.sum()
        return cls(rest, beta, c, -(constant + sum(held)) / 2, -(constant + _squares(total, c)) / 2)

    @classmethod
    def of(cls, rows: BinnedRows, columns: Array, starts: tuple[NoiseModel, ...]) -> Hypothesis:
        """The hypothesis with a rest of its own, from the residual of each start the likelier one, or a walk's.

        From one start alone a linear drift is swallowed by a slow rest.
        """
        found = []
        for start in starts:
            first = cls.given(rows, columns, start)
            rest = NoiseModel.of(first.residual(rows, columns), rows.interval_s, rows.policy, rows.sight)
            found.append(cls.given(rows, columns, rest))
        best = max(found, key=_whole)
        if rows.sight is None:
            return best
        walk = NoiseModel.walking(best.residual(rows, columns), rows.interval_s, rows.policy, rows.sight)
        beside_walk = cls.given(rows, columns, walk)
        far_behind = beside_walk.whole < best.whole - FAR_NATS
        return best if far_behind else max(best, beside_walk._at_its_size(rows, columns), key=_whole)

    def _at_its_size(self, rows: BinnedRows, columns: Array) -> Hypothesis:
        """The hypothesis with axes that walk, from the size of this one to that in which it is likeliest.

        Iron takes up what is slowest of a wander that comes and goes with the motion: what it leaves has the spectrum
        of a smaller or a faster one, beside which a drift would stand out.
        """
        now = self
        for factor in (2.0, 0.5):
            while True:
                larger = replace(now.rest, turning=factor * now.rest.turning)
                then = Hypothesis.given(rows, columns, larger)
                if then.whole < now.whole + SAME_NATS:
                    break
                now = then
        return now

    def residual(self, rows: BinnedRows, columns: Array) -> Array:
        """What base and effects leave (n, q)."""
        beta = np.broadcast_to(self.beta, rows.base.shape[1:])
        left = rows.target - np.einsum("nqp,qp->nq", rows.base, beta)
        return np.asarray(left - np.einsum("nqk,k->nq", columns, self.c))


def _whole(one: Hypothesis) -> float:
    return one.whole


def gains(rows: BinnedRows, inside: Array, several: Sequence[Array], rest: NoiseModel) -> Array:
    """Nats (m,) that each of m groups of columns (n, q, k) explains by itself in sample, beside base and `inside`."""
    found = informations(rows, inside, several, rest)
    return np.array([(N[-1, -1] - _squares(N, _solved(N))) / 2 for N in found])


def informations(rows: BinnedRows, inside: Array, several: Sequence[Array], rest: NoiseModel) -> list[Array]:
    """Products (k + 1, k + 1) of each of m groups of whitened columns (n, q, k) and of the target, which is last.

    Base and `inside` are fitted anew: the products are of what these leave of columns and target.
    """
    stacked = np.concatenate([rows.base, inside, *several, rows.target[:, :, None]], axis=2)
    z, _ = rest.whitened(rows.row_s, rows.count, stacked)
    N, k = _products(_without_base(z, rows)[0]), inside.shape[2]
    left = N[k:, k:] - N[k:, :k] @ _taken(N, k)
    some = np.diag(left) > GONE * np.diag(N)[k:]
    N = left * np.outer(some, some)
    ends = np.cumsum([one.shape[2] for one in several])
    groups = [np.r_[end - one.shape[2] : end, len(N) - 1] for one, end in zip(several, ends, strict=True)]
    return [N[np.ix_(g, g)] for g in groups]


def information_by_part(rows: BinnedRows, inside: Array, columns: Array, rest: NoiseModel, parts: int) -> list[Array]:
    """The same products (k + 1, k + 1) of one group of columns, summed over each of so many parts of the rows."""
    stacked = np.concatenate([rows.base, inside, columns, rows.target[:, :, None]], axis=2)
    z, _ = rest.whitened(rows.row_s, rows.count, stacked)
    free, k = _without_base(z, rows)[0], inside.shape[2]
    left = free[:, :, k:] - free[:, :, :k] @ _taken(_products(free), k)
    return [_products(part) for part in np.array_split(left, parts)]


def _taken(products: Array, k: int) -> Array:
    """Coefficients (k, j - k) by which the first k columns make the others, from products (j, j); units may differ."""
    size = np.sqrt(np.maximum(np.diag(products), 1e-300))
    N = products / np.outer(size, size)
    through = np.linalg.pinv(N[:k, :k], rcond=1e-12, hermitian=True) @ N[:k, k:]
    return np.asarray(through * size[k:] / size[:k, None])


def _without_base(z: Array, rows: BinnedRows) -> tuple[Array, Array]:
    """Columns (n, q, j) less their part along the first p, those of the base, and that part's coefficients (q, p, .).

    Each output by itself; outputs that have the coefficients in common are further rows, and these (1, p, .).
    """
    shape, p = z.shape, rows.base.shape[2]
    z = z.reshape(-1, 1, shape[2]) if rows.common else z
    B, others = z[:, :, :p], z[:, :, p:]
    BB = np.einsum("nqi,nqj->qij", B, B, optimize=True)
    inverse = np.linalg.pinv(BB, rcond=1e-13, hermitian=True)
    through = inverse @ np.einsum("nqi,nqj->qij", B, others, optimize=True)
    free = others - np.einsum("nqp,qpj->nqj", B, through, optimize=True)
    return free.reshape(*shape[:2], -1), through


def _products(free: Array) -> Array:
    """Products (j, j) of columns (n, q, j), summed over rows and outputs."""
    flat = free.reshape(-1, free.shape[2])
    return np.asarray(flat.T @ flat)


def _solved(products: Array) -> Array:
    """Coefficients c (k,) of least squares from products (k + 1, k + 1) of the columns and the target."""
    size = np.sqrt(np.maximum(np.diag(products)[:-1], 1e-300))
    inverse = np.linalg.pinv(products[:-1, :-1] / np.outer(size, size), rcond=1e-9, hermitian=True)
    return np.asarray(inverse @ (products[:-1, -1] / size) / size)


def _squares(products: Array, c: Array) -> float:
    """Sum of squares that coefficients leave."""
    v = np.append(c, -1.0)
    return float(v @ products @ v)


def white(q: int) -> NoiseModel:
    """A rest without slow processes."""
    return NoiseModel(np.ones(1), np.ones(q), np.zeros((q, 1)))
