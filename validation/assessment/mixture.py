"""Posterior of a sensor model's parameters: least squares with spreads of the disturbances that the data choose.

misfit = J p + X t + v,  t_j ~ N(0, spread_j^2),  var v = scatter sigma^2

The scatter is that of the legs over white noise, for the heading errors [BellMcCaffrey2002]; spreads weigh as the
marginal likelihood of the misfit says, beside a probability that a disturbance is absent.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT
from validation.assessment.sensor_model import IRON

ROUNDING = 1e-13
"""Eigenvalue of a scaled normal matrix below which a direction is rounding."""
LEAST_CHI2 = 1e-12
"""Least chi-square over its freedom in a draw: with next to no freedom a chi-square rounds to zero, and a draw of a
million standard deviations is as good as any larger one."""
FULL = 1.0 - 1e-6
"""Largest share of a direction's information in a single leg; a share of 1 leaves no residual."""
ROUNDS = 2
"""Rounds in which noise and spreads follow each other."""
Spreads = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Component:
    """A Student's t distribution of the parameters: mean (k,), covariance (k, k), freedom; and its weight.

    scatter : of the legs over white noise. noise_nT2 : of a row.
    """

    weight: float
    mean: Array
    covariance: Array
    freedom: float
    scatter: float
    noise_nT2: float
    spreads: Spreads

    def drawn(self, count: int, rng: np.random.Generator) -> Array:
        """Return draws (count, k)."""
        values, axes = np.linalg.eigh(self.covariance)
        z = rng.standard_normal((count, len(values))) * np.sqrt(values.clip(0.0))
        heavy = np.sqrt(self.freedom / np.maximum(rng.chisquare(self.freedom, count), LEAST_CHI2 * self.freedom))
        return np.asarray(self.mean + (z * heavy[:, None]) @ axes.T)


@dataclass(frozen=True, eq=False)
class LegSquares:
    """Squares (legs, k + 1, k + 1) of columns and misfit, the group of each column, and the number of rows.

    wanted : (q, k) the heading errors, linear in the parameters. firm, centre : prior precision (k,), 1 / nT^2, and
    mean (k,) of the iron, and mean of the disturbances. unit_nT : F, the unit of the spreads. present : groups that
    are there beforehand.
    """

    squares: Array
    groups: tuple[str, ...]
    rows: int
    wanted: Array
    firm: Array
    centre: Array
    unit_nT: float
    present: tuple[str, ...] = ()

    @cached_property
    def total(self) -> Array:
        """Return the squares of all legs."""
        return np.asarray(self.squares.sum(axis=0))

    @cached_property
    def disturbances(self) -> tuple[str, ...]:
        """Return the groups but the iron."""
        return tuple(dict.fromkeys(name for name in self.groups if name != IRON))

    def where(self, *names: str) -> NDArray[np.bool_]:
        """Return a mask (k,) of the parameters of some groups."""
        return np.array([name in names for name in self.groups])

    def of(self, kept: NDArray[np.bool_]) -> LegSquares:
        """Return the squares of some of the columns (k,)."""
        index = np.append(np.flatnonzero(kept), len(kept))
        groups = tuple(name for name, keep in zip(self.groups, kept, strict=True) if keep)
        squares = self.squares[:, index][:, :, index]
        return replace(
            self,
            squares=squares,
            groups=groups,
            wanted=self.wanted[:, kept],
            firm=self.firm[kept],
            centre=self.centre[kept],
        )

    def solved(self, spreads: Spreads, weight: float = 1.0) -> Component:
        """Return the posterior for spreads in parts of the field; disturbances of spread zero are absent."""
        present = {IRON, *(name for name, spread in spreads.items() if spread > 0)}
        kept = self.where(*present)
        found = self.of(kept)._given(spreads)
        mean, covariance = np.zeros(len(kept)), np.zeros((len(kept), len(kept)))
        mean[kept] = found.mean
        covariance[np.ix_(kept, kept)] = found.covariance
        return Component(weight, mean, covariance, found.freedom, found.scatter, found.noise_nT2, dict(spreads))

    def _given(self, spreads: Spreads) -> Component:
        """Return the posterior with every disturbance present; noise and scatter follow from the residual."""
        precision = self._precision(spreads)
        noise, scatter, freedom = float(self.total[-1, -1]) / self.rows, 1.0, 1.0
        for _ in range(ROUNDS):
            prior = precision * noise * scatter
            root = _root(self.total[:-1, :-1] + np.diag(prior))
            mean = root @ (root.T @ (self.total[:-1, -1] + prior * self.centre))
            free = self._free(root)
            noise = self._noise(mean, free)
            moved, each = self.by_legs(root, mean, self.wanted)
            white = float(np.trace(each.sum(axis=0)))
            scatter = max(ASSESSMENT.least_scatter, float(np.sum(moved**2)) / white / noise)
            freedom = min(white**2 / float(np.sum(each**2)), free)
        return Component(1.0, mean, noise * scatter * root @ root.T, freedom, scatter, noise, spreads)

    def _precision(self, spreads: Spreads) -> Array:
        """Return the prior precision (k,) of iron and disturbances, 1 / nT^2."""
        wide = np.array([spreads.get(name, 0.0) * self.unit_nT for name in self.groups])
        return np.where(self.where(IRON), self.firm, 1.0 / np.where(wide > 0, wide, 1.0) ** 2)

    def _free(self, root: Array) -> float:
        """Return the rows less the parameters that the data determine, tr R^T N R; a prior determines the rest."""
        return float(max(1.0, self.rows - np.trace(root.T @ self.total[:-1, :-1] @ root)))

    def _noise(self, mean: Array, free: float) -> float:
        """Return the variance of a row about a mean (k,), nT^2; not below rounding."""
        square = float(self.total[-1, -1])
        left = square - 2.0 * float(mean @ self.total[:-1, -1]) + float(mean @ self.total[:-1, :-1] @ mean)
        return max(left, ROUNDING * square, np.finfo(float).tiny) / free

    def by_legs(self, root: Array, mean: Array, wanted: Array) -> tuple[Array, Array]:
        """Return each leg's part (legs, q) of the wanted, and its covariance (legs, q, q) in unit white noise.

        root (k, k) : root root^T is the inverse of the normal matrix. Unbiased in white noise for any weights of legs.
        """
        N, slope = self.squares[:, :-1, :-1], self.squares[:, :-1, -1]
        own = np.einsum("ki,lkm,mj->lij", root, N, root, optimize=True)
        share, along = np.linalg.eigh(own)
        pull = np.einsum("lik,li->lk", along, (slope - N @ mean) @ root) / np.sqrt(1.0 - share.clip(0.0, FULL))
        rows = wanted @ root
        moved = np.einsum("lik,lk->li", along, pull) @ rows.T
        return moved, np.einsum("ai,lij,bj->lab", rows, own, rows, optimize=True)

    def marginal(self) -> Marginal:
        """Return the marginal likelihood of the spreads, the iron fitted."""
        slope, iron = self.total[:-1, -1], self.where(IRON)
        first = float(self.total[-1, -1]) / self.rows
        N = self.total[:-1, :-1] + np.diag(first * np.where(iron, self.firm, 0.0))
        root, inner = _root(N), _root(N[np.ix_(iron, iron)])
        mean = root @ (root.T @ slope)
        noise = self._noise(mean, self._free(root))
        scatter = max(1.0, *(self._scatter(root, mean, name) / noise for name in self.disturbances))
        cross = inner @ inner.T @ N[np.ix_(iron, ~iron)]
        left = N[np.ix_(~iron, ~iron)] - N[np.ix_(~iron, iron)] @ cross
        names = tuple(name for name in self.groups if name != IRON)
        pull = slope[~iron] - cross.T @ slope[iron] - left @ self.centre[~iron]
        return Marginal(left / (noise * scatter), pull / (noise * scatter), names, self.unit_nT, self.present)

    def _scatter(self, root: Array, mean: Array, name: str) -> float:
        """Return the scatter of a group's parameters by legs over unit white noise."""
        moved, each = self.by_legs(root, mean, np.eye(len(mean))[self.where(name)])
        white = each.sum(axis=0)
        return float(np.trace(np.linalg.pinv(white, hermitian=True) @ (moved.T @ moved))) / len(white)


@dataclass(frozen=True, eq=False)
class Marginal:
    """Marginal likelihood of spreads: N (k, k) and slope (k,) of the disturbances in units of the noise."""

    N: Array
    slope: Array
    names: tuple[str, ...]
    unit_nT: float
    present: tuple[str, ...] = ()

    def log(self, spreads: Spreads) -> float:
        """Return the logarithm: -1/2 log det(1 + D N D) + 1/2 g^T D (1 + D N D)^-1 D g, D the spreads."""
        wide = self.unit_nT * np.array([spreads[name] for name in self.names])
        inside = np.eye(len(wide)) + wide[:, None] * self.N * wide
        pull = wide * self.slope
        return float(pull @ np.linalg.solve(inside, pull) - np.linalg.slogdet(inside)[1]) / 2.0

    def weights(self, spreads: Spreads, name: str) -> dict[float, float]:
        """Return the probability of each spread of a group, the others' given."""
        tried = (0.0, *ASSESSMENT.spreads)
        before = np.full(len(tried), (1.0 - ASSESSMENT.absent) / len(ASSESSMENT.spreads))
        before[0] = ASSESSMENT.absent
        if name in self.present:
            tried, before = tried[1:], before[1:]
        logs = np.array([self.log({**spreads, name: spread}) for spread in tried]) + np.log(before)
        chances = np.exp(logs - logs.max())
        return dict(zip(tried, (chances / chances.sum()).tolist(), strict=True))


def mixture(squares: LegSquares) -> tuple[Component, ...]:
    """Return the posterior: every likely combination of spreads, each given the likeliest of the groups that follow."""
    names = squares.disturbances
    marginal, spreads = squares.marginal(), dict.fromkeys(names, 0.0)
    for _ in range(ROUNDS):
        for name in names:
            weights = marginal.weights(spreads, name)
            spreads[name] = max(weights, key=lambda spread: weights[spread])
    weighed: list[tuple[Spreads, float]] = [(spreads, 1.0)]
    for name in names:
        weighed = [branch for tried, weight in weighed for branch in _branches(marginal, tried, weight, name)]
    whole = sum(weight for _, weight in weighed)
    return tuple(squares.solved(tried, weight / whole) for tried, weight in weighed)


def _branches(marginal: Marginal, spreads: Spreads, weight: float, name: str) -> Iterator[tuple[Spreads, float]]:
    """Yield spreads with every likely spread of a group, and their weights."""
    for spread, one in marginal.weights(spreads, name).items():
        if weight * one >= ASSESSMENT.least_weight:
            yield {**spreads, name: spread}, weight * one


def _root(normal: Array) -> Array:
    """Return R (k, k) with R R^T the inverse of a normal matrix; directions of rounding are left wide."""
    square = np.diag(normal)
    size = np.sqrt(np.maximum(square, ROUNDING * max(float(square.max()), np.finfo(float).tiny)))
    values, axes = np.linalg.eigh(normal / np.outer(size, size))
    return np.asarray(axes / np.sqrt(values.clip(ROUNDING)) / size[:, None])
