"""Nats by which a leg separates two effects: the misfit of the wrong effect, refitted together with the iron."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.parameter_search import refine_between_neighbours
from diagnosis.problem.blocks import Cut, Sums, fit, squares, sums
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
        squares = {candidate: self._unexplained_squares(target, candidate) for candidate in wrong}
        nearest = min(squares, key=lambda candidate: squares[candidate])
        moved = self._refined_candidate(nearest, target)
        return (
            min(squares[nearest], squares[moved] if moved in squares else self._unexplained_squares(target, moved)) / 2
        )

    def total_nats(self, true: Effect) -> float:
        """Nats of an effect next to the iron."""
        remaining = self.without_base(self.target(true))
        return float((remaining**2).sum()) / 2

    def fitted(self, true: Effect, wrong: Sequence[Candidate]) -> Effect:
        """The best setting of a wrong candidate, fitted to a true effect."""
        target = self.target(true)
        best = min(wrong, key=lambda candidate: self._unexplained_squares(target, candidate))
        s = self._sums(target, best)
        return best.to_effect(fit(s, s.all_folds).c)

    def _sums(self, target: Array, candidate: Candidate) -> Sums:
        return sums(Cut(len(target), 1), self.base, candidate.columns(self.problem), target, self.problem.usable)

    def _unexplained_squares(self, target: Array, candidate: Candidate) -> float:
        """Squares of a target (n, q) not explained by a candidate."""
        s = self._sums(target, candidate)
        return squares(s, fit(s, s.all_folds), s.all_folds)

    def _refined_candidate(self, candidate: Candidate, target: Array) -> Candidate:
        """A candidate with its place refined to fit a target (n, q), or a listed value interpolated."""
        name = candidate.effect.with_role("place")
        if name is None:
            return refine_between_neighbours(candidate, partial(self._unexplained_squares, target)) or candidate
        path = ThinnedPath.of(self.problem, target)
        place = path.best_near(np.array(dict(candidate.nonlinear)[name]))
        return candidate.at({name: tuple(float(v) for v in place)})
