"""Nats by which a leg separates two effects: the misfit of the wrong effect, refitted together with the iron."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from diagnosis.evidence.projections import products, solved, squares_left, without_rounding
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.parameter_search import refine_between_neighbours
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects


@dataclass(frozen=True, eq=False)
class LegProblem:
    """A recording or a leg with permanent effects; iron: whether iron is refitted."""

    problem: LinearProblem
    permanent: tuple[Effect, ...]
    iron: bool

    def target(self, true: Effect) -> Array:
        """Contribution (n, q) of an effect in the simulator's chain, in units of the noise."""
        with_it, without = (
            apply_deterministic(effects, self.problem.state)[0]
            for effects in (insert_effects(self.permanent, [true]), self.permanent)
        )
        return np.asarray((with_it - without) / self.problem.sigma_nT * self.problem.usable[:, None])

    @cached_property
    def candidates(self) -> dict[str, list[Candidate]]:
        """Changes of the iron, and every effect whose causes are recorded."""
        return iron_candidates() | propose_candidates(self.problem)

    @property
    def base(self) -> Array:
        """Columns (n, p) of refitted iron."""
        return self.problem.base if self.iron else np.zeros((len(self.problem.state), 1))

    def without_base(self, target: Array) -> Array:
        """The part of a target (n, q) not explained by iron."""
        return np.asarray(target - self.base @ np.linalg.lstsq(self.base, target, rcond=None)[0])

    def missing_nats(self, true: Effect, wrong: Sequence[Candidate]) -> float:
        """Nats lacking to the best setting of a wrong candidate, refitted, where `true` is the true effect.

        Half the squares, in units of the noise, left of the simulator's prediction.
        """
        target = self.target(true)
        misfit = partial(self._unexplained_squares, target)
        nearest = min(wrong, key=misfit)
        return min(map(misfit, (nearest, self._refined_candidate(nearest, target)))) / 2

    def total_nats(self, true: Effect) -> float:
        """Nats of an effect next to the iron."""
        remaining = self.without_base(self.target(true))
        return float((remaining**2).sum()) / 2

    def fitted(self, true: Effect, wrong: Sequence[Candidate]) -> Effect:
        """The best setting of a wrong candidate, fitted to a true effect."""
        target = self.target(true)
        best = min(wrong, key=partial(self._unexplained_squares, target))
        return best.to_effect(solved(self._products(target, best)))

    def _products(self, target: Array, candidate: Candidate) -> Array:
        """Products (k + 1, k + 1) of a candidate's columns and a target (n, q), without the part that iron explains."""
        both = np.concatenate([candidate.columns(self.problem), target[:, :, None]], axis=2)
        return products(without_rounding(self.without_base(both.reshape(len(both), -1)).reshape(both.shape), both))

    def _unexplained_squares(self, target: Array, candidate: Candidate) -> float:
        """Squares of a target (n, q) not explained by a candidate."""
        N = self._products(target, candidate)
        return squares_left(N, solved(N))

    def _refined_candidate(self, candidate: Candidate, target: Array) -> Candidate:
        """A candidate with its place refined to fit a target (n, q), or a listed value interpolated."""
        name = candidate.effect.with_role("place")
        if name is None:
            return refine_between_neighbours(candidate, partial(self._unexplained_squares, target)) or candidate
        path = ThinnedPath.of(self.problem, target)
        place = path.best_near(np.array(dict(candidate.nonlinear)[name]))
        return candidate.at({name: tuple(float(v) for v in place)})
