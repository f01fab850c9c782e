"""Least squares cut into folds and blocks of time: fits and held-out scores from sums computed once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calib.numerics.colour import white_ratios
from calib.numerics.symmetric import symmetric_inverse
from diagnosis.policy import Policy
from scenarios.arrays import Array


@dataclass(frozen=True)
class Cut:
    """Division of n samples into m blocks of `length` samples; samples after the last block are not used.

    `segment` consecutive blocks form a segment, held out or trained on as a whole; segments are assigned in turn to
    `folds` folds.
    """

    length: int
    m: int
    segment: int = 1
    folds: int = 1

    @classmethod
    def of(cls, n: int, interval_s: float, policy: Policy) -> Cut:
        """Blocks of `block_s`, shorter where the recording would have fewer than `least_blocks`."""
        length = max(2, min(round(policy.block_s / interval_s), n // policy.least_blocks))
        return cls(length, n // length, policy.segment_blocks, policy.splits)

    @property
    def fold(self) -> NDArray[np.intp]:
        """Fold (m,) of each block."""
        return np.asarray(np.arange(self.m) // self.segment % self.folds)

    def blocks(self, values: Array) -> Array:
        """Values (n, ...) as blocks (m, length, ...)."""
        return values[: self.m * self.length].reshape(self.m, self.length, *values.shape[1:])

    def means(self, values: Array) -> Array:
        """Block means (m, ...) of values (n, ...)."""
        return np.asarray(self.blocks(values).mean(axis=1))

    def products(self, left: Array, right: Array) -> Array:
        """``sum left^T right`` (folds, a, b) over the rows of each fold, of left (n, r, a) and right (n, r, b)."""
        long, whole = self.segment * self.length, self.m // self.segment
        out = np.zeros((self.folds, left.shape[2], right.shape[2]))
        split = whole * long
        L, R = (one[:split].reshape(whole, long * one.shape[1], one.shape[2]) for one in (left, right))
        each = L.transpose(0, 2, 1) @ R
        for fold in range(self.folds):
            out[fold] = each[fold :: self.folds].sum(axis=0)
        rows = (self.m * self.length - split) * left.shape[1]
        rest = [one[split : self.m * self.length].reshape(rows, one.shape[2]) for one in (left, right)]
        out[whole % self.folds] += rest[0].T @ rest[1]
        return out


def held_out_folds(policy: Policy) -> Iterator[NDArray[np.bool_]]:
    """Masks (splits,) of the folds that each split holds out; the remaining folds are trained on.

    The first split trains on the start, the initial state of effects with memory, and on the end.
    """
    for split in range(1, policy.splits + 1):
        yield np.asarray((np.arange(policy.splits) - split) % policy.splits < policy.held_segments)


@dataclass(frozen=True)
class Sums:
    """Sums of the columns of a problem: base B (p), effects E (k), target y (q outputs).

    BB (f, p, p), BE (f, p, q, k), EE (f, k, k), By (f, p, q), Ey (f, k), yy (f,): products over each of f folds; B1 (m,
    p), E1 (m, q, k), y1 (m, q): sums over each of m blocks; count (m,): samples. The outputs have one base and
    coefficients of their own. With shared coefficients and a base for each output, the outputs are further rows: BE (f,
    p, 1, k), By (f, p, 1), B1 (m, q, p).
    """

    BB: Array
    BE: Array
    EE: Array
    By: Array
    Ey: Array
    yy: Array
    B1: Array
    E1: Array
    y1: Array
    count: Array

    @property
    def width(self) -> int:
        """Number k of effect columns."""
        return int(self.EE.shape[1])

    @property
    def all_folds(self) -> NDArray[np.bool_]:
        """Mask (f,) of all folds."""
        return np.ones(len(self.yy), bool)


def sums(cut: Cut, base: Array, columns: Array, target: Array, usable: Array) -> Sums:
    """Sums of base (n, p), or (n, q, p) with shared coefficients, columns (n, q, k) and target (n, q)."""
    B, y = _as_rows(base, target[:, :, None])
    q, f, p, r = target.shape[1], cut.folds, B.shape[2], y.shape[2]
    bare = Sums(
        BB=cut.products(B, B),
        BE=np.zeros((f, p, r, 0)),
        EE=np.zeros((f, 0, 0)),
        By=cut.products(B, y),
        Ey=np.zeros((f, 0)),
        yy=cut.products(target[:, :, None], target[:, :, None])[:, 0, 0],
        B1=cut.blocks(base).sum(axis=1),
        E1=np.zeros((cut.m, q, 0)),
        y1=cut.blocks(target).sum(axis=1),
        count=cut.blocks(usable).sum(axis=1),
    )
    return extend_sums(bare, cut, base, (), columns, target)


def extend_sums(
    s: Sums, cut: Cut, base: Array, accepted_columns: Sequence[Array], columns: Array, target: Array
) -> Sums:
    """Sums extended by columns (n, q, k), given the accepted column groups (n, q, .) already in the sums."""
    none = np.zeros((cut.folds, 0, columns.shape[2]))
    across = np.concatenate([none, *(cut.products(accepted, columns) for accepted in accepted_columns)], axis=1)
    own = cut.products(columns, columns)
    taken = cut.products(*_as_rows(base, columns)).reshape(*s.BE.shape[:3], columns.shape[2])
    upper, lower = np.concatenate([s.EE, across], axis=2), np.concatenate([across.transpose(0, 2, 1), own], axis=2)
    return replace(
        s,
        BE=np.concatenate([s.BE, taken], axis=3),
        EE=np.concatenate([upper, lower], axis=1),
        Ey=np.concatenate([s.Ey, cut.products(columns, target[:, :, None])[:, :, 0]], axis=1),
        E1=np.concatenate([s.E1, cut.blocks(columns).sum(axis=1)], axis=2),
    )


def _as_rows(base: Array, columns: Array) -> tuple[Array, Array]:
    """Base (n, r, p) and columns (n, r, .) as rows: all outputs in one row, or a row for each output."""
    n, q, k = columns.shape
    return (base[:, None, :], columns.reshape(n, 1, q * k)) if base.ndim == 2 else (base, columns)


@dataclass(frozen=True)
class BlockFit:
    """Coefficients beta (p, q), or (p, 1) if shared, of the base, c (k,) of the effects, and c's covariance."""

    beta: Array
    c: Array
    covariance: Array


def fit(s: Sums, use: NDArray[np.bool_]) -> BlockFit:
    """Least squares on the folds `use` (f,): c from the orthogonal complement of the base, then beta."""
    BB, BE, EE = s.BB[use].sum(axis=0), s.BE[use].sum(axis=0), s.EE[use].sum(axis=0)
    By, Ey = s.By[use].sum(axis=0), s.Ey[use].sum(axis=0)
    inverse = symmetric_inverse(BB, 1e-13)
    through = np.einsum("pr,rqk->pqk", inverse, BE)
    S = EE - np.einsum("pqi,pqk->ik", BE, through)
    size = np.sqrt(np.maximum(np.diag(EE), 1e-300))
    covariance = symmetric_inverse(S / np.outer(size, size), 1e-9) / np.outer(size, size)
    c = covariance @ (Ey - np.einsum("pqk,pq->k", through, By))
    return BlockFit(inverse @ By - np.einsum("pqk,k->pq", through, c), c, covariance)


def squares(s: Sums, f: BlockFit, use: NDArray[np.bool_]) -> float:
    """Sum of squared residuals on the folds `use` (f,)."""
    pulled = f.c @ s.EE[use].sum(axis=0) @ f.c - 2 * f.c @ s.Ey[use].sum(axis=0)
    BB, By = s.BB[use].sum(axis=0), s.By[use].sum(axis=0)
    based = np.einsum("pq,pr,rq->", f.beta, BB, f.beta) - 2 * np.einsum("pq,pq->", f.beta, By)
    cross = 2 * np.einsum("pq,pqk,k->", f.beta, s.BE[use].sum(axis=0), f.c)
    return float(s.yy[use].sum() + pulled + based + cross)


def block_sums(s: Sums, f: BlockFit) -> Array:
    """Sums (m, q) of the residual over each block."""
    return np.asarray(s.y1 - (s.B1 @ f.beta).reshape(s.y1.shape) - s.E1 @ f.c)


def colour(total: Array, count: Array, policy: Policy) -> float:
    """W: variance of block means over the variance for unit white noise, averaged over outputs; 1 for white noise."""
    full = count > policy.filled_block * count.max()
    return float(white_ratios(total[full], count[full]).mean()) if full.any() else 1.0


def inflation(s: Sums, f: BlockFit, policy: Policy) -> float:
    """V = max(1, W over 5 s, 20 s and 80 s): inflation of a log-likelihood ratio by coloured residuals."""
    total, count = block_sums(s, f), s.count
    worst = 1.0
    for several in policy.colour_blocks:
        whole = len(total) // several * several
        if whole < policy.least_colour_means * several:
            break
        sums_of = total[:whole].reshape(-1, several, total.shape[1]).sum(axis=1)
        worst = max(worst, colour(sums_of, count[:whole].reshape(-1, several).sum(axis=1), policy))
    return worst
