"""How many nats a leg would tell two effects apart by: what the wrong one, refitted with the iron, lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.library.candidates import Candidate
from validation.diagnosis.problem.blocks import Cut, Sums, fit, squares, sums
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.repair.chain import joined


@dataclass(frozen=True, eq=False)
class Experiment:
    """The recording in hand and a leg after it, with the effects that act always; iron: whether it is refitted."""

    hand: LinearProblem
    leg: LinearProblem
    always: tuple[Effect, ...]
    iron: bool

    def lacks(self, true: Effect, wrong: Sequence[Candidate]) -> float:
        """Nats by which the best setting of a wrong candidate, refitted, falls short on the leg where one is true.

        Half of the squares, in units of the noise, that it leaves of the simulator's prediction on both, less those
        on the recording in hand alone.
        """
        alone, together = [], []
        for one in wrong:
            parts = [self._sums(problem, true, one) for problem in (self.hand, self.leg)]
            alone.append(_left(parts[:1]))
            together.append(_left(parts))
        return max(min(together) - min(alone), 0.0) / 2

    def evidence(self, true: Effect) -> float:
        """Nats that an effect explains on both, beside the iron where that is refitted."""
        left = 0.0
        for problem in (self.hand, self.leg):
            target = predicted(problem, self.always, true) * problem.usable[:, None]
            base = problem.base if self.iron else np.zeros((len(target), 1))
            none = sums(Cut(len(target), 1), base, np.zeros((*target.shape, 0)), target, problem.usable)
            left += _left([none])
        return left / 2

    def _sums(self, problem: LinearProblem, true: Effect, wrong: Candidate) -> Sums:
        target = predicted(problem, self.always, true)
        base = problem.base if self.iron else np.zeros((len(target), 1))
        usable = problem.usable
        return sums(Cut(len(target), 1), base, wrong.columns(problem), target * usable[:, None], usable)

    def fitted(self, true: Effect, others: Sequence[Candidate]) -> Effect:
        """The effect of another candidate's best setting as it is fitted to the recording in hand where one is true."""
        several = [self._sums(self.hand, true, one) for one in others]
        best = int(np.argmin([_left([s]) for s in several]))
        return others[best].made(fit(several[best], np.ones(1, bool)).c)


def predicted(problem: LinearProblem, always: Sequence[Effect], effect: Effect) -> Array:
    """What an effect adds (n, q) in the simulator's chain, in units of the noise."""
    with_it, without = (
        apply_deterministic(some, problem.state)[0] for some in (joined(always, [effect]), tuple(always))
    )
    return np.asarray((with_it - without) / problem.sigma_nT)


def _left(parts: Sequence[Sums]) -> float:
    """Squares that one fit to several parts leaves."""
    whole = Sums(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Sums)})
    use = np.ones(len(parts), bool)
    return squares(whole, fit(whole, use), use)
