"""The baseline that a candidate must beat: a problem cut into blocks, with the columns of the accepted effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.blocks import Cut, Sums, extend_sums, fit, held_out_folds, inflation, squares, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


@dataclass(frozen=True)
class Baseline:
    """A problem cut into blocks, the columns (n, q, k) of each accepted effect, and the sums of all columns.

    Baselines share the column arrays, which are the largest part of memory for a recording of ten hours.
    """

    problem: LinearProblem
    cut: Cut
    accepted_columns: tuple[Array, ...]
    sums: Sums

    @classmethod
    def of(cls, problem: LinearProblem, several: Iterable[Array] = ()) -> Baseline:
        """The baseline of a problem with the columns (n, q, k) of several effects accepted; none by default."""
        cut = Cut.of(len(problem.target), problem.state.interval_s, problem.policy)
        return cls(problem, cut, (), sums(cut, problem.base, problem.target, problem.usable)).with_all(several)

    @property
    def all_folds(self) -> NDArray[np.bool_]:
        """Mask (f,) of all folds."""
        return self.sums.all_folds

    @property
    def splits(self) -> list[NDArray[np.bool_]]:
        """Masks (f,) of the folds that each split holds out."""
        return list(held_out_folds(self.problem.policy))

    @cached_property
    def squares(self) -> float:
        """Sum of squared residuals of the base and the accepted effects, in units of the noise."""
        return squares(self.sums, fit(self.sums, self.all_folds), self.all_folds)

    @cached_property
    def held_out_squares(self) -> list[float]:
        """Sum of squared residuals on the folds that each split holds out, of the fit to the other folds."""
        return [squares(self.sums, fit(self.sums, ~held), held) for held in self.splits]

    def residual(self, use: NDArray[np.bool_] | None = None) -> Array:
        """Residual (n, q) of base and accepted effects over the noise, fitted to the folds `use` (f,)."""
        f = fit(self.sums, self.all_folds if use is None else use)
        ends = np.cumsum([columns_of.shape[2] for columns_of in self.accepted_columns])[:-1]
        residual = self.problem.target - (self.problem.base @ f.beta).reshape(self.problem.target.shape)
        for columns, c in zip(self.accepted_columns, np.split(f.c, ends), strict=False):
            residual -= columns @ c
        return np.asarray(residual * self.problem.usable[:, None])

    def left_of_last(self) -> float:
        """``sum f^2 r^2 / sum f^4``: power of the residual r where the last accepted effect f acts, over its own."""
        columns = self.accepted_columns[-1]
        f, r = columns @ fit(self.sums, self.all_folds).c[-columns.shape[2] :], self.residual()
        return float((f**2 * r**2).sum() / max(float((f**4).sum()), 1e-300))

    def with_columns(self, columns: Array) -> Baseline:
        """The baseline with further columns (n, q, k) accepted; kept, and summed, as rounded to half of the memory."""
        rounded: Any = columns.astype(np.float32)
        sums = self.sums_with(rounded.astype(np.float64))
        return replace(self, accepted_columns=(*self.accepted_columns, rounded), sums=sums)

    def with_all(self, several: Iterable[Array]) -> Baseline:
        """The baseline with the columns (n, q, k) of several effects accepted, in their order."""
        return reduce(Baseline.with_columns, several, self)

    def sums_with(self, columns: Array) -> Sums:
        """Sums of the accepted columns and of further columns (n, q, k); the further columns are not stored."""
        known = (self.problem.target[:, :, None], *self.accepted_columns)
        return extend_sums(self.sums, self.cut, self.problem.base, known, columns)

    def held_out_samples(self) -> NDArray[np.bool_]:
        """Mask (n,) of the samples that the first split holds out.

        Segments are halved until the held-out samples have between `fair_share` and 1 - `fair_share` of the power of
        every accepted column: an event within a single segment would be wholly in the training data, or wholly held
        out.
        """
        policy, n = self.problem.policy, len(self.problem.recording)
        power = np.concatenate(
            [np.zeros((n, 0)), *((columns**2).sum(axis=1) for columns in self.accepted_columns)], axis=1
        )
        power = power[:, power.any(axis=0)]
        length = self.cut.length * policy.segment_blocks
        while True:
            held = self.splits[0][np.arange(n) // length % policy.splits]
            share = power[held].sum(axis=0) / power.sum(axis=0)
            enough = ((policy.fair_share < share) & (share < 1 - policy.fair_share)).all()
            if enough or length * self.problem.state.interval_s < 2 * policy.least_segment_s:
                return np.asarray(held)
            length //= 2

    def evidence_of(self, columns: Array) -> float:
        """Evidence ``D = [ll_held(M + c) - ll_held(M)] / V`` in nats of columns c (n, q, k) beside the baseline M."""
        joint = self.sums_with(columns)
        return self.held_out_gain(joint) / inflation(joint, fit(joint, self.all_folds), self.problem.policy)

    def evidence_on_all(self, columns: Array) -> float:
        """Evidence in nats of columns (n, q, k) on all blocks, where training folds do not determine the
        coefficients.
        """
        joint, k = self.sums_with(columns), columns.shape[2]
        whole = fit(joint, self.all_folds)
        V = inflation(joint, whole, self.problem.policy)
        return nats_on_all(self.squares - squares(joint, whole, self.all_folds), V, k, len(joint.count))

    def held_out_gain(self, *settings: Sums) -> float:
        """Nats on held-out segments, before the inflation, of the columns that the sums hold beyond the baseline's.

        Of several settings the one that fits the training segments best is held out, in each split. Every sample is
        held out `held_segments` times.
        """
        gain = 0.0
        for held, before in zip(self.splits, self.held_out_squares, strict=True):
            fits = [(joint, fit(joint, ~held)) for joint in settings]
            joint, trained = fits[int(np.argmin([squares(joint, one, ~held) for joint, one in fits]))]
            gain += (before - squares(joint, trained, held)) / 2
        return gain / self.problem.policy.held_segments


IsClean = Callable[[Baseline, str], bool]
"""(baseline with an effect accepted, name of the effect) -> whether the residual is white."""


def nats_on_all(fewer_squares: float, V: float, k: int, m: int) -> float:
    """``dS / 2 / V - k / 2 ln m`` nats: k columns that reduce the squares of all m blocks by dS, V the inflation."""
    return fewer_squares / 2 / V - k * math.log(m) / 2


def added_share(start: Baseline, before: Baseline, squares: float) -> float:
    """Share of the gap of `start` that a fit with some remaining squares explains beyond `before`."""
    return (before.squares - squares) / max(start.squares - start.problem.target.size, 1e-9)
