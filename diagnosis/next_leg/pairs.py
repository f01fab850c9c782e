"""Pairs of effects for a leg to separate, and the nats by which the wrong one, refitted with the iron, misses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from diagnosis.evidence.projections import products, solved, squares_left, without_rounding
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.drivers import may_drive
from diagnosis.library.parameter_search import refine_between_neighbours, search_parameters
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import EvidenceKind, NamedEffect
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.parameters import ACTIVE_WINDOW, Window


@dataclass(frozen=True, eq=False)
class LegProblem:
    """A recording or a leg with permanent effects; iron: whether iron is refitted."""

    problem: LinearProblem
    permanent: tuple[Effect, ...]
    iron: bool

    @cached_property
    def candidates(self) -> dict[str, list[Candidate]]:
        """Changes of the iron, and every effect whose causes are recorded."""
        return iron_candidates() | propose_candidates(self.problem)

    def target(self, true: Effect) -> Array:
        """Contribution (n, q) of an effect in the simulator's chain, in units of the noise."""
        chains = (insert_effects(self.permanent, [true]), self.permanent)
        with_it, without = (apply_deterministic(chain, self.problem.state)[0] for chain in chains)
        return np.asarray((with_it - without) / self.problem.sigma_nT * self.problem.usable[:, None])

    def total_nats(self, true: Effect) -> float:
        """Nats of an effect next to the iron."""
        return float((self._without_base(self.target(true)) ** 2).sum()) / 2

    def missing_nats(self, true: Effect, wrong: Sequence[Candidate]) -> float:
        """Nats lacking to the best setting of a wrong candidate, refitted, where `true` is the true effect.

        Half the squares, in units of the noise, left of the simulator's prediction. A place is refined, a listed value
        interpolated.
        """
        target = self.target(true)
        misfit = partial(self._unexplained_squares, target)
        nearest = min(wrong, key=misfit)
        if (place := nearest.effect.with_role("place")) is None:
            refined = refine_between_neighbours(nearest, misfit) or nearest
        else:
            best_m = ThinnedPath.of(self.problem, target).best_near(np.array(dict(nearest.nonlinear)[place]))
            refined = nearest.at({place: tuple(float(v) for v in best_m)})
        return min(map(misfit, (nearest, refined))) / 2

    def fitted(self, true: Effect, wrong: Sequence[Candidate]) -> Effect:
        """The best setting of a wrong candidate, fitted to a true effect."""
        target = self.target(true)
        best = min(wrong, key=partial(self._unexplained_squares, target))
        return best.to_effect(solved(self._products(target, best)))

    def settings(self, name: str, true: Effect, window: Window) -> list[Candidate]:
        """Settings at which a candidate may resemble a true effect, in the window of the named effect."""
        candidates = [
            candidate.at({ACTIVE_WINDOW.name: window}) if window and candidate.can_have_window else candidate
            for candidate in self.candidates[name]
        ]
        return search_parameters(self.problem, self._without_base(self.target(true)), candidates)

    def _without_base(self, target: Array) -> Array:
        """The part of a target (n, q) not explained by iron, if refitted."""
        if not self.iron:
            return target
        return np.asarray(target - self.problem.base @ np.linalg.lstsq(self.problem.base, target, rcond=None)[0])

    def _products(self, target: Array, candidate: Candidate) -> Array:
        """Products (k + 1, k + 1) of a candidate's columns and a target (n, q), without the part that iron explains."""
        both = np.concatenate([candidate.columns(self.problem), target[:, :, None]], axis=2)
        return products(without_rounding(self._without_base(both.reshape(len(both), -1)).reshape(both.shape), both))

    def _unexplained_squares(self, target: Array, candidate: Candidate) -> float:
        """Squares of a target (n, q) not explained by a candidate."""
        N = self._products(target, candidate)
        return squares_left(N, solved(N))


@dataclass(frozen=True, eq=False)
class HypothesisPair:
    """Two hypotheses on a recording: fitted effects, and candidate settings of each.

    On a leg both act throughout. listed : whether the second is a look-alike; otherwise a change of the iron that the
    recording distinguishes from the first, and the leg must as well.
    """

    first: Effect
    second: Effect
    first_candidates: tuple[Candidate, ...]
    second_candidates: tuple[Candidate, ...]
    listed: bool

    @classmethod
    def of(cls, recording: LegProblem, cause: NamedEffect, rival: str, *, listed: bool) -> HypothesisPair | None:
        """Pair a named effect with a rival fitted to it.

        None for a rival without a setting, as a body without a place beside the path.
        """
        effect, window = cause.effect, cause.effect.active_s
        rivals = recording.settings(rival, effect, window)
        if not rivals:
            return None
        second = recording.fitted(effect, rivals)
        own = (Candidate.of(effect), *recording.settings(cause.name, second, window))
        permanent, permanent_rivals = (
            tuple(candidate.at({ACTIVE_WINDOW.name: None}) for candidate in candidates) for candidates in (own, rivals)
        )
        return cls(replace(effect, active_s=None), replace(second, active_s=None), permanent, permanent_rivals, listed)

    def separation_nats(self, leg: LegProblem) -> float:
        """Nats by which a leg separates both hypotheses, whichever is true; zero if the leg shows one of them only.

        Zero for a separation within the form error of a family, or of second order in a change of the iron; at most the
        total nats of the named effect on the leg. If one hypothesis contains the other, the simpler is preferred unless
        the leg shows more. At rest all changes of the iron are one constant.
        """
        first, second = self.first, self.second
        missing = any(leg.problem.missing_inputs(type(effect)) for effect in (first, second))
        if missing or not (leg.iron or leg.problem.turns):
            return 0.0
        size, nats = leg.total_nats(first), list[float]()
        if first.name not in second.traits.contains:
            nats.append(leg.missing_nats(first, self.second_candidates))
        if self.listed and second.name not in first.traits.contains:
            nats.append(leg.missing_nats(second, self.first_candidates))
        smallest = min((size, *nats)) if nats else 0.0
        return smallest if smallest > self._form_share(leg) * size else 0.0

    def _form_share(self, leg: LegProblem) -> float:
        """Share of an effect without information: a form error within a family, or terms of second order in the iron.

        Includes the part of a drift beyond a temperature of nearly the same course, as a temperature may act late or
        bent.
        """
        first, second, policy = type(self.first), type(self.second), leg.problem.policy
        family = bool(first.traits.family) and first.traits.family == second.traits.family
        courses = may_drive(second, first) or may_drive(first, second)
        of_course = 1 - policy.nearly_all**2 if courses else 0.0
        return max(policy.same_family if family else 0.0, of_course, 0.0 if leg.iron else policy.same_iron)


def pairs_of(recording: LegProblem, cause: NamedEffect) -> Iterator[HypothesisPair]:
    """Pair a named effect with each look-alike observable in another run, and iron with all other changes of iron."""
    may_recur = {name for name in recording.candidates if not BY_NAME[name].traits.one_run}
    rivals = [
        (rival, True)
        for rival in cause.alternatives
        if {cause.name, rival} <= may_recur and not are_equivalent(cause.name, rival)
    ]
    if cause.kind is EvidenceKind.IRON:
        rivals += [(rival, False) for rival in iron_candidates() if rival not in (cause.name, *cause.alternatives)]
    pairs = (HypothesisPair.of(recording, cause, rival, listed=listed) for rival, listed in rivals)
    return (pair for pair in pairs if pair is not None)


def are_equivalent(first: str, second: str) -> bool:
    """Whether `Traits.equivalent_to` states that two effects agree on every motion."""
    return BY_NAME[first].traits.equivalent_to == second or BY_NAME[second].traits.equivalent_to == first
