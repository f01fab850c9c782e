"""Least squares cut into blocks of time: sums once, then every split, fit and held-out score from them alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.numerics.colour import white_ratios
from sim.state import Array
from validation.diagnosis.policy import Policy


@dataclass(frozen=True)
class Sums:
    """Sums over m blocks of a problem's columns: base B (p), candidates E (k), target y (q outputs).

    BB (m, p, p), BE (m, p, q, k), EE (m, k, k), By (m, p, q), Ey (m, k), yy (m,); B1 (m, p), E1 (m, q, k), y1 (m, q)
    plain sums, for block means; count (m,) samples; q outputs share one base, with coefficients of their own. Where
    they have the coefficients in common, each with columns of its own, the outputs are further rows: BE (m, p, 1, k),
    By (m, p, 1), B1 (m, q, p).
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
        """How many candidate columns there are."""
        return int(self.EE.shape[1])


@dataclass(frozen=True)
class Cut:
    """How n samples are cut: `length` samples a block, `m` whole blocks; what is left at the end is not used."""

    length: int
    m: int

    @classmethod
    def of(cls, n: int, interval_s: float, policy: Policy) -> Cut:
        """Blocks of `block_s`, shorter where the record has not `least_blocks` of them."""
        length = max(2, min(round(policy.block_s / interval_s), n // policy.least_blocks))
        return cls(length, n // length)

    def blocks(self, values: Array) -> Array:
        """(n, ...) as (m, length, ...)."""
        return values[: self.m * self.length].reshape(self.m, self.length, *values.shape[1:])

    def means(self, values: Array) -> Array:
        """Means (m, ...) of values (n, ...) over the blocks."""
        return np.asarray(self.blocks(values).mean(axis=1))


def held_out(m: int, policy: Policy) -> Iterator[NDArray[np.bool_]]:
    """Which of m blocks (m,) each split holds out: segments of some blocks go round, the others are trained on."""
    segment = np.arange(m) // policy.segment_blocks
    for split in range(policy.splits):
        yield np.asarray((segment - split) % policy.splits < policy.held_segments)


def sums(cut: Cut, base: Array, columns: Array, target: Array, usable: Array) -> Sums:
    """The sums of base (n, p), or (n, q, p) with common coefficients, columns (n, q, k) and target (n, q)."""
    B, E, y = cut.blocks(base), cut.blocks(columns), cut.blocks(target)
    m, length, q, k = E.shape
    each, beside = (length, q) if base.ndim == 2 else (length * q, 1)
    Bs = B.reshape(m, each, base.shape[-1])
    Bt = Bs.transpose(0, 2, 1)
    flat, rows = E.reshape(m, each, beside * k), E.reshape(m, length * q, k)
    weight = cut.blocks(usable)
    return Sums(
        BB=Bt @ Bs,
        BE=(Bt @ flat).reshape(m, base.shape[-1], beside, k),
        EE=rows.transpose(0, 2, 1) @ rows,
        By=Bt @ y.reshape(m, each, beside),
        Ey=np.einsum("mrk,mr->mk", rows, y.reshape(m, length * q)),
        yy=np.einsum("mlq,mlq->m", y, y),
        B1=B.sum(axis=1),
        E1=E.sum(axis=1),
        y1=y.sum(axis=1),
        count=weight.sum(axis=1),
    )


@dataclass(frozen=True)
class Fit:
    """Base coefficients beta (p, q), or common ones (p, 1), candidates' c (k,), and the inverse normal matrix of c."""

    beta: Array
    c: Array
    covariance: Array


def fit(s: Sums, use: NDArray[np.bool_]) -> Fit:
    """Least squares on the blocks `use` (m,): c from the base's orthogonal complement, then beta."""
    BB, BE, EE = s.BB[use].sum(axis=0), s.BE[use].sum(axis=0), s.EE[use].sum(axis=0)
    By, Ey = s.By[use].sum(axis=0), s.Ey[use].sum(axis=0)
    inverse = np.linalg.pinv(BB, rcond=1e-13, hermitian=True)
    through = np.einsum("pr,rqk->pqk", inverse, BE)
    S = EE - np.einsum("pqi,pqk->ik", BE, through)
    size = np.sqrt(np.maximum(np.diag(EE), 1e-300))
    covariance = np.linalg.pinv(S / np.outer(size, size), rcond=1e-9, hermitian=True) / np.outer(size, size)
    c = covariance @ (Ey - np.einsum("pqk,pq->k", through, By))
    return Fit(inverse @ By - np.einsum("pqk,k->pq", through, c), c, covariance)


def squares(s: Sums, f: Fit, use: NDArray[np.bool_]) -> float:
    """Sum of squared residuals on the blocks `use`."""
    pulled = f.c @ s.EE[use].sum(axis=0) @ f.c - 2 * f.c @ s.Ey[use].sum(axis=0)
    BB, By = s.BB[use].sum(axis=0), s.By[use].sum(axis=0)
    based = np.einsum("pq,pr,rq->", f.beta, BB, f.beta) - 2 * np.einsum("pq,pq->", f.beta, By)
    cross = 2 * np.einsum("pq,pqk,k->", f.beta, s.BE[use].sum(axis=0), f.c)
    return float(s.yy[use].sum() + pulled + based + cross)


def block_sums(s: Sums, f: Fit) -> Array:
    """Sum of the residual in each block (m, q)."""
    return np.asarray(s.y1 - (s.B1 @ f.beta).reshape(s.y1.shape) - s.E1 @ f.c)


def colour(total: Array, count: Array, policy: Policy) -> float:
    """W: variance of block means over that of white noise of variance one, averaged over outputs; 1 if white."""
    full = count > policy.filled_block * count.max()
    return float(white_ratios(total[full], count[full]).mean()) if full.any() else 1.0


def inflation(s: Sums, f: Fit, policy: Policy) -> float:
    """V = max(1, W over 5 s, 20 s and 80 s): by how much the residual's colour inflates a log-likelihood ratio."""
    total, count = block_sums(s, f), s.count
    worst = 1.0
    for several in policy.colour_blocks:
        whole = len(total) // several * several
        if whole < policy.least_colour_means * several:
            break
        sums_of = total[:whole].reshape(-1, several, total.shape[1]).sum(axis=1)
        worst = max(worst, colour(sums_of, count[:whole].reshape(-1, several).sum(axis=1), policy))
    return worst
