"""The ground on which candidates are judged: a problem in blocks, with the effects already in."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.blocks import Cut, Sums, fit, held_out, inflation, joined, squares, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


@dataclass(frozen=True)
class Baseline:
    """A problem cut into blocks, with the columns (n, q, k) of each effect already in, and the sums of all.

    Grounds share the columns: of ten hours they are the largest part of what is held.
    """

    problem: LinearProblem
    cut: Cut
    inside: tuple[Array, ...]
    sums: Sums

    @classmethod
    def of(cls, problem: LinearProblem, several: Iterable[Array] = ()) -> Baseline:
        """The ground with the columns (n, q, k) of each effect already in, none at first."""
        (n, q), policy = problem.target.shape, problem.policy
        cut = Cut.of(n, problem.state.interval_s, policy)
        bare = sums(cut, problem.base, np.zeros((n, q, 0)), problem.target, problem.usable)
        return cls(problem, cut, (), bare).with_all(several)

    @property
    def everything(self) -> NDArray[np.bool_]:
        """All folds (f,)."""
        return self.sums.everything

    @property
    def splits(self) -> list[NDArray[np.bool_]]:
        """The folds (f,) that each split holds out."""
        return list(held_out(self.problem.policy))

    @property
    def squares(self) -> float:
        """Squares that the base and the effects already in leave, in units of the noise."""
        return squares(self.sums, fit(self.sums, self.everything), self.everything)

    def residual(self, use: NDArray[np.bool_] | None = None) -> Array:
        """What the base and the effects already in leave (n, q), in units of the noise; fitted to the folds `use`."""
        f = fit(self.sums, self.everything if use is None else use)
        ends = np.cumsum([one.shape[2] for one in self.inside])[:-1]
        left = self.problem.target - (self.problem.base @ f.beta).reshape(self.problem.target.shape)
        for columns, c in zip(self.inside, np.split(f.c, ends), strict=False):
            left -= columns @ c
        return np.asarray(left * self.problem.usable[:, None])

    def beside(self, columns: Array) -> Baseline:
        """The ground with further columns (n, q, k) in."""
        return replace(self, inside=(*self.inside, columns), sums=self.joined(columns))

    def with_all(self, several: Iterable[Array]) -> Baseline:
        """The ground with the columns (n, q, k) of several effects in, in their order."""
        return reduce(Baseline.beside, several, self)

    def joined(self, columns: Array) -> Sums:
        """Sums of the effects already in and further columns (n, q, k), which are not kept."""
        return joined(self.sums, self.cut, self.problem.base, self.inside, columns, self.problem.target)

    def held_samples(self) -> NDArray[np.bool_]:
        """The samples (n,) that the first split holds out, in segments short enough to show what is in.

        An event that lies in one segment would be trained on whole, or held out whole: segments are halved until those
        held out have `least_held` of the power of every column that is in.
        """
        policy, n = self.problem.policy, len(self.problem.recording)
        power = np.concatenate([np.zeros((n, 0)), *((one**2).sum(axis=1) for one in self.inside)], axis=1)
        power = power[:, power.any(axis=0)]
        length = self.cut.length * policy.segment_blocks
        while True:
            held = self.splits[0][np.arange(n) // length % policy.splits]
            share = power[held].sum(axis=0) / power.sum(axis=0)
            enough = ((policy.least_held < share) & (share < 1 - policy.least_held)).all()
            if enough or length * self.problem.state.interval_s < 2 * policy.least_segment_s:
                return np.asarray(held)
            length //= 2

    def mean_gain(self, gains: list[float]) -> float:
        """Nats of the whole record from the gains on each split: every sample is held out `held_segments` times."""
        return sum(gains) / self.problem.policy.held_segments

    def evidence_of(self, columns: Array) -> float:
        """Evidence D of columns (n, q, k) that belong to no effect: nats on held-out segments over the inflation."""
        return self.evidence_in(self.joined(columns))

    def evidence_on_all(self, columns: Array) -> float:
        """Evidence of columns (n, q, k) on all blocks: of what acts where data held out do not determine it."""
        joint, k = self.joined(columns), columns.shape[2]
        whole = fit(joint, self.everything)
        V = inflation(joint, whole, self.problem.policy)
        return nats_on_all(self.squares - squares(joint, whole, self.everything), V, k, len(joint.count))

    def evidence_in(self, joint: Sums) -> float:
        """The same of what is in the sums beside what is in the ground."""
        return self.held_gain(joint) / inflation(joint, fit(joint, self.everything), self.problem.policy)

    def held_gain(self, joint: Sums) -> float:
        """Nats on held-out segments of what is in the sums beside what is in the ground."""
        gains = [
            (squares(self.sums, fit(self.sums, ~held), held) - squares(joint, fit(joint, ~held), held)) / 2
            for held in self.splits
        ]
        return self.mean_gain(gains)


IsClean = Callable[[Baseline, str], bool]
"""(ground with an effect in, its name) -> whether what is left is white."""


def nats_on_all(fewer_squares: float, V: float, k: int, m: int) -> float:
    """Nats ``fewer / 2 / V - k / 2 ln m`` of k columns that leave fewer squares of all m blocks, inflated by V."""
    return fewer_squares / 2 / V - k * math.log(m) / 2


def added_share(start: Baseline, before: Baseline, squares: float) -> float:
    """Share of the first gap that ordinary least squares explain beside what is in before, where they leave squares."""
    return (before.squares - squares) / max(start.squares - start.problem.target.size, 1e-9)
