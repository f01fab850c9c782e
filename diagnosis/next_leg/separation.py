"""How many nats a leg would tell two effects apart by: what the wrong one, refitted with the iron, lacks on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from diagnosis.library.candidates import Candidate, changes_of_iron, proposed
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.parameter_search import between_neighbours
from diagnosis.problem.blocks import Cut, Sums, fit, squares, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects


@dataclass(frozen=True, eq=False)
class Flown:
    """The recording in hand, or a leg, with the effects that act always; iron: whether it is refitted."""

    problem: LinearProblem
    always: tuple[Effect, ...]
    iron: bool

    def target(self, true: Effect) -> Array:
        """What an effect adds (n, q) in the simulator's chain, in units of the noise."""
        with_it, without = (
            apply_deterministic(some, self.problem.state)[0]
            for some in (insert_effects(self.always, [true]), self.always)
        )
        return np.asarray((with_it - without) / self.problem.sigma_nT * self.problem.usable[:, None])

    @cached_property
    def candidates(self) -> dict[str, list[Candidate]]:
        """What may be asked of it: changes of the iron, and every effect whose causes it holds."""
        return changes_of_iron() | proposed(self.problem)

    @property
    def base(self) -> Array:
        """Columns (n, p) that are refitted."""
        return self.problem.base if self.iron else np.zeros((len(self.problem.state), 1))

    def without_base(self, target: Array) -> Array:
        """What of a target (n, q) the iron does not take up."""
        return np.asarray(target - self.base @ np.linalg.lstsq(self.base, target, rcond=None)[0])

    def lacks(self, true: Effect, wrong: Sequence[Candidate]) -> float:
        """Nats by which the best setting of a wrong candidate, refitted, falls short where an effect is true.

        Half of the squares, in units of the noise, that it leaves of the simulator's prediction.
        """
        target = self.target(true)
        left = {one: self._left(target, one) for one in wrong}
        nearest = min(left, key=lambda one: left[one])
        moved = self._moved(nearest, target)
        return min(left[nearest], left[moved] if moved in left else self._left(target, moved)) / 2

    def size(self, true: Effect) -> float:
        """Nats of an effect beside the iron."""
        left = self.without_base(self.target(true))
        return float((left**2).sum()) / 2

    def fitted(self, true: Effect, wrong: Sequence[Candidate]) -> Effect:
        """The effect of another candidate's best setting as it is fitted where one is true."""
        target = self.target(true)
        best = min(wrong, key=lambda one: self._left(target, one))
        s = self._sums(target, best)
        return best.made(fit(s, s.everything).c)

    def _sums(self, target: Array, one: Candidate) -> Sums:
        return sums(Cut(len(target), 1), self.base, one.columns(self.problem), target, self.problem.usable)

    def _left(self, target: Array, one: Candidate) -> float:
        """Squares that a candidate leaves of a target (n, q)."""
        s = self._sums(target, one)
        return squares(s, fit(s, s.everything), s.everything)

    def _moved(self, one: Candidate, target: Array) -> Candidate:
        """A body at the place near its own that fits a target (n, q) best, a listed value between its neighbours."""
        name = one.effect.with_role("place")
        if name is None:
            return between_neighbours(one, partial(self._left, target)) or one
        path = ThinnedPath.of(self.problem, target)
        place = path.best_near(np.array(dict(one.nonlinear)[name]))
        return one.at({name: tuple(float(v) for v in place)})
