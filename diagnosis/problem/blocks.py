"""Least squares cut into folds and blocks of time: fits and held-out scores from sums computed once."""

from __future__ import annotations

from collections.abc import Sequence
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

    def totals(self, values: Array) -> Array:
        """Sums (m, ...) of values (n, ...) over each block."""
        return np.asarray(np.einsum("ml...->m...", self.blocks(values)))

    def means(self, values: Array) -> Array:
        """Block means (m, ...) of values (n, ...)."""
        return self.totals(values) / self.length

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


def held_out_folds(policy: Policy) -> NDArray[np.bool_]:
    """Masks (splits, folds) of the folds that each split holds out; the remaining folds are trained on.

    The first split trains on the start, the initial state of effects with memory, and on the end.
    """
    folds = np.arange(policy.splits)
    return np.asarray((folds - folds[:, None] - 1) % policy.splits < policy.held_segments)


@dataclass(frozen=True)
class Sums:
    """Sums of a base B (p) and of columns C = [y, E]: target y and k effect columns E, each with q outputs.

    BB (f, p, p), BC (f, p, q, 1 + k), CC (f, 1 + k, 1 + k): products over each of f folds; B1 (m, p), C1 (m, q, 1 + k):
    sums over each of m blocks; count (m,): samples. The outputs have one base and coefficients of their own. With
    shared coefficients and a base for each output, the outputs are further rows: BC (f, p, 1, 1 + k), B1 (m, q, p).
    """

    BB: Array
    BC: Array
    CC: Array
    B1: Array
    C1: Array
    count: Array

    @property
    def width(self) -> int:
        """Number k of effect columns."""
        return int(self.CC.shape[1]) - 1

    @property
    def samples(self) -> float:
        """Number of usable samples times outputs."""
        return float(self.count.sum() * self.C1.shape[1])

    @property
    def all_folds(self) -> NDArray[np.bool_]:
        """Mask (f,) of all folds."""
        return np.ones(len(self.BB), bool)


def sums(cut: Cut, base: Array, target: Array, usable: Array) -> Sums:
    """Sums of base (n, p), or (n, q, p) with shared coefficients, and target (n, q), without effects."""
    f, q, rows = cut.folds, target.shape[1], _as_rows(base, target[:, :, None])[0]
    bare = Sums(
        BB=cut.products(rows, rows),
        BC=np.zeros((f, rows.shape[2], q if base.ndim == 2 else 1, 0)),
        CC=np.zeros((f, 0, 0)),
        B1=cut.totals(base),
        C1=np.zeros((cut.m, q, 0)),
        count=cut.totals(usable),
    )
    return extend_sums(bare, cut, base, (), target[:, :, None])


def extend_sums(s: Sums, cut: Cut, base: Array, known: Sequence[Array], columns: Array) -> Sums:
    """Sums extended by columns (n, q, k), given the groups (n, q, .) of columns already in the sums, target first."""
    none = np.zeros((cut.folds, 0, columns.shape[2]))
    across = np.concatenate([none, *(cut.products(before, columns) for before in known)], axis=1)
    upper = np.concatenate([s.CC, across], axis=2)
    lower = np.concatenate([across.transpose(0, 2, 1), cut.products(columns, columns)], axis=2)
    taken = cut.products(*_as_rows(base, columns)).reshape(*s.BC.shape[:3], columns.shape[2])
    return replace(
        s,
        BC=np.concatenate([s.BC, taken], axis=3),
        CC=np.concatenate([upper, lower], axis=1),
        C1=np.concatenate([s.C1, cut.totals(columns)], axis=2),
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

    @property
    def of_columns(self) -> Array:
        """Factors (1 + k,) of target and effects that give the residual, but for the base."""
        return np.concatenate([[1.0], -self.c])


def fit(s: Sums, use: NDArray[np.bool_]) -> BlockFit:
    """Least squares on the folds `use` (f,): c from the orthogonal complement of the base, then beta."""
    BB, BC, CC = (products[use].sum(axis=0) for products in (s.BB, s.BC, s.CC))
    inverse = symmetric_inverse(BB, 1e-13)
    through = np.einsum("pr,rqk->pqk", inverse, BC)
    S = CC - np.einsum("pqi,pqk->ik", BC, through)
    size = np.sqrt(np.maximum(np.diag(CC)[1:], 1e-300))
    covariance = symmetric_inverse(S[1:, 1:] / np.outer(size, size), 1e-9) / np.outer(size, size)
    c = covariance @ S[1:, 0]
    return BlockFit(through[:, :, 0] - through[:, :, 1:] @ c, c, covariance)


def squares(s: Sums, f: BlockFit, use: NDArray[np.bool_]) -> float:
    """Sum of squared residuals on the folds `use` (f,)."""
    BB, BC, CC = (products[use].sum(axis=0) for products in (s.BB, s.BC, s.CC))
    left = BC @ f.of_columns
    return float(f.of_columns @ CC @ f.of_columns + (f.beta * (BB @ f.beta - 2 * left)).sum())


def block_sums(s: Sums, f: BlockFit) -> Array:
    """Sums (m, q) of the residual over each block."""
    left = s.C1 @ f.of_columns
    return np.asarray(left - (s.B1 @ f.beta).reshape(left.shape))


def colour(total: Array, count: Array, policy: Policy) -> float:
    """W: variance of block means over the variance for unit white noise, averaged over outputs; 1 for white noise."""
    full = count > policy.filled_block * count.max()
    return float(white_ratios(total[full], count[full]).mean()) if full.any() else 1.0


def inflation(s: Sums, f: BlockFit, policy: Policy) -> float:
    """V: inflation of a log-likelihood ratio by coloured residuals."""
    return largest_excess(block_sums(s, f), s.count, policy)


def largest_excess(total: Array, count: Array, policy: Policy) -> float:
    """V = max(1, W over 5 s, 20 s and 80 s) of sums (m, q) over blocks of samples (m,)."""
    worst = 1.0
    for several in policy.colour_blocks:
        whole = len(total) // several * several
        if whole < policy.least_colour_means * several:
            break
        sums_of = total[:whole].reshape(-1, several, total.shape[1]).sum(axis=1)
        worst = max(worst, colour(sums_of, count[:whole].reshape(-1, several).sum(axis=1), policy))
    return worst
