"""Ridge regression with the ridge and the error from blocks of rows that are held out in turn.

y = X c + e,  c = (N + ridge D)^-1 X^T y,  N = X^T X, D its diagonal
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array

RIDGES = np.logspace(-9.0, 3.0, 13)
"""Ridges that are tried, in units of the squared length of a column; the last leaves no more than 0.1 % of a term."""


@dataclass(frozen=True, eq=False)
class BlockSquares:
    """Sums of squares and products of columns X and target y in blocks of rows, with columns of length one.

    N (blocks, k, k), g = X^T y (blocks, k), rows (blocks,), square: y^T y (blocks,), size (k,): lengths of columns
    """

    N: Array
    g: Array
    square: Array
    rows: Array
    size: Array

    @classmethod
    def of(cls, columns: Array, target: Array, blocks: int, size: Array | None = None) -> BlockSquares:
        """Sums over `blocks` equal blocks of columns (n, k) and target (n,); size: lengths given in place of theirs."""
        if size is None:
            size = np.linalg.norm(columns, axis=0)
            size = np.where(size > 0, size, 1.0)
        parts = np.array_split(np.arange(len(target)), blocks)
        pairs = [(columns[rows] / size, target[rows]) for rows in parts]
        return cls(
            N=np.array([X.T @ X for X, _ in pairs]),
            g=np.array([X.T @ y for X, y in pairs]),
            square=np.array([y @ y for _, y in pairs]),
            rows=np.array([len(y) for _, y in pairs], dtype=float),
            size=size,
        )

    def merged(self, parts: int) -> BlockSquares:
        """The sums over fewer, longer blocks."""
        groups = np.array_split(np.arange(len(self.rows)), parts)
        each = (self.N, self.g, self.square, self.rows)
        N, g, square, rows = (np.array([of[group].sum(axis=0) for group in groups]) for of in each)
        return BlockSquares(N, g, square, rows, self.size)

    @property
    def raw_rms(self) -> Array:
        """Root mean square of the target in each block (blocks,)."""
        return np.asarray(np.sqrt(self.square / self.rows))

    @property
    def condition(self) -> float:
        """Condition number of the columns."""
        return float(np.sqrt(np.linalg.cond(self.N.sum(axis=0))))

    def whole(self, rms: Array) -> float:
        """Root mean square of all rows, from the blocks' (blocks,)."""
        return float(np.sqrt(np.average(rms**2, weights=self.rows)))

    def chosen_ridge(self, without: int | None = None) -> float:
        """The ridge that predicts blocks best with parameters of all others; block `without` is left out of all."""
        kept = [j for j in range(len(self.rows)) if j != without]
        N, g = self.N[kept], self.g[kept]
        found = solutions(N.sum(axis=0) - N, g.sum(axis=0) - g, RIDGES)
        error = np.einsum("brk,bkl,brl->r", found, N, found) - 2.0 * np.einsum("brk,bk->r", found, g)
        return float(RIDGES[int(np.argmin(error))])

    def of_others(self, ridges: Array) -> Array:
        """Parameters (blocks, k) of all other blocks, with ridges (blocks,), for columns of length one."""
        N, g = self.N.sum(axis=0) - self.N, self.g.sum(axis=0) - self.g
        return np.array([solutions(N[j : j + 1], g[j : j + 1], ridges[j : j + 1])[0, 0] for j in range(len(g))])

    def rms(self, parameters: Array) -> Array:
        """Root mean square of each block's residual (blocks,) with its parameters (blocks, k)."""
        predicted = np.einsum("bk,bkl,bl->b", parameters, self.N, parameters)
        error = self.square + predicted - 2.0 * np.sum(parameters * self.g, axis=1)
        return np.asarray(np.sqrt(error.clip(0.0) / self.rows))

    def solution(self, ridge: float) -> tuple[Array, Array]:
        """Parameters (k,) of all blocks, and their covariance (k, k) by the blocks' scatter.

        covariance = v N^-1,  v = tr(N^-1 sum_j g_j g_j^T) / k,  g_j = X_j^T e_j

        e_j : residual of block j by parameters of all others. The covariance is that of least squares: a ridge lessens
        the scatter of what the rows do not determine, by an error towards zero that no scatter shows.
        """
        N, g = self.N.sum(axis=0), self.g.sum(axis=0)
        slopes = self.g - np.einsum("bkl,bl->bk", self.N, self.of_others(np.full(len(self.rows), ridge)))
        inverse = np.linalg.inv(N + RIDGES[0] * np.eye(len(N)))
        variance = float(np.einsum("bk,kl,bl->", slopes, inverse, slopes)) / len(N)
        found = solutions(N[None], g[None], np.array([ridge]))[0, 0]
        return found / self.size, variance * inverse / np.outer(self.size, self.size)


def solutions(N: Array, g: Array, ridges: Array) -> Array:
    """Ridge solutions (b, r, k) of normal equations N (b, k, k), g (b, k) for ridges (r,)."""
    values, axes = np.linalg.eigh(N)
    along = np.einsum("bkl,bk->bl", axes, g)
    scaled = along[:, None, :] / (values.clip(0.0)[:, None, :] + ridges[None, :, None])
    return np.asarray(np.einsum("bkl,brl->brk", axes, scaled))
