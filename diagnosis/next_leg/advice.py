"""The leg that best separates named effects from their look-alikes, computed by the simulator.

The wrong one of a pair of effects is refitted with the iron: what it lacks on a leg are the nats that separate both.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.evidence.hypothesis import products, solved, squares_left, without_rounding
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.drivers import may_drive
from diagnosis.library.parameter_search import refine_between_neighbours, search_parameters
from diagnosis.next_leg.legs import CandidateLeg, legs_of
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut, colour
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patch_model
from diagnosis.result import Diagnosis, EvidenceKind, Flight, NamedEffect
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.parameters import ACTIVE_WINDOW, Window
from validation.text import digits, listed

MINUTE_S = 60.0
MOST_TIMES = 6
"""Largest number of flights of a leg in one scenario."""


def advised(diagnosis: Diagnosis) -> Diagnosis:
    """Add the leg to fly next, and look-alikes separated by no leg, to the advice; a fixed station cannot fly."""
    if not diagnosis.problem.turns:
        return diagnosis
    tables = leg_tables(diagnosis)
    alike = {table.cause.name: [table.cause.name, *table.inseparable] for table in tables if table.inseparable}
    remarks = (f"No leg that the simulator can fly distinguishes {listed(names)}." for names in alike.values())
    found = replace(diagnosis, advice=(*remarks, *diagnosis.advice))
    flights = [(flight, table.cause) for table in tables if (flight := table.flight) is not None]
    if not flights:
        return found
    flight, cause = max(flights, key=lambda one: one[0].nats)
    return replace(found, advice=(f"Next, {_words(flight, cause)}.", *found.advice), next_flight=flight)


@dataclass(frozen=True, eq=False)
class LegTable:
    """A named effect, p pairs with its look-alikes, l legs, and the nats (p, l) by which the legs separate them."""

    cause: NamedEffect
    pairs: Sequence[HypothesisPair]
    legs: Sequence[CandidateLeg]
    nats: Array
    policy: Policy

    @property
    def separable(self) -> list[int]:
        """Indices of pairs separated by some leg."""
        return [i for i, of_pair in enumerate(self.nats) if of_pair.max(initial=0.0) >= self.policy.least_leg_nats]

    @property
    def inseparable(self) -> list[str]:
        """Look-alikes that agree with the effect on every motion, or are separated by no leg."""
        twins = [other for other in self.cause.alternatives if are_equivalent(self.cause.name, other)]
        alike = [pair.second.name for i, pair in enumerate(self.pairs) if pair.listed and i not in self.separable]
        return [*twins, *alike]

    @property
    def flight(self) -> Flight | None:
        """The leg with the largest nats for its least separated pair, and the nearest look-alike there, if any."""
        of_look_alikes = [i for i in self.separable if self.pairs[i].listed]
        if not of_look_alikes:
            return None
        best = int(np.argmax(self.nats[self.separable].min(axis=0)))
        nearest = min(of_look_alikes, key=lambda i: float(self.nats[i, best]))
        leg, other, nats = self.legs[best], self.pairs[nearest].second.name, float(self.nats[nearest, best])
        if nats < self.policy.least_leg_nats:
            return None
        times = int(np.clip(math.ceil(self.policy.leg_margin * self.policy.apart / nats), 1, MOST_TIMES))
        needed_s = leg.duration_s * self.policy.apart / nats
        return Flight(leg.repeated(times), self.cause.name, other, leg.words, leg.duration_s, nats, needed_s)


def leg_tables(diagnosis: Diagnosis) -> list[LegTable]:
    """Separation by every leg of the model's vehicle, for each named effect; no leg is tried without look-alikes."""
    problem = diagnosis.problem
    permanent = patch_model(diagnosis.model, (), problem).chain()
    recorded = [LegProblem(problem, permanent, iron=cause.kind is not EvidenceKind.IRON) for cause in diagnosis.named]
    pairs = [[*pairs_of(*one)] for one in zip(recorded, diagnosis.named, strict=True)]
    legs = legs_of(diagnosis.model) if any(pairs) else []
    flown = [(leg, posed) for leg in legs if (posed := leg.problem(problem, permanent)) is not None]
    V, tables = inflation_of(problem, diagnosis.residual), list[LegTable]()
    for cause, recording, several in zip(diagnosis.named, recorded, pairs, strict=True):
        on_legs = [replace(recording, problem=posed) for _, posed in flown]
        nats = np.array([[pair.separation_nats(leg) / V for leg in on_legs] for pair in several])
        tables.append(LegTable(cause, several, [leg for leg, _ in flown], nats, problem.policy))
    return tables


def inflation_of(problem: LinearProblem, residual: Array) -> float:
    """Inflation of nats by the colour of a residual (n, q), at least 1."""
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    return max(1.0, colour(cut.totals(residual), np.full(cut.m, cut.length), problem.policy))


def _words(flight: Flight, cause: NamedEffect) -> str:
    """What to fly, for how long, and with which result; what acted in a part of the run must act throughout."""
    window = cause.effect.active_s
    acting = "" if window is None else ", with what acted from {:.0f} s to {:.0f} s at work".format(*window)
    needed = "less than one is" if flight.needed_s < MINUTE_S else f"{digits(flight.needed_s / MINUTE_S)} min are"
    return (
        f"fly {flight.leg}{acting} (next.toml): {digits(flight.leg_s / MINUTE_S)} min distinguish {flight.name} from "
        f"{flight.other} by {digits(flight.nats)} nats, by the simulator; {needed} needed"
    )


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

        def misfit(candidate: Candidate) -> float:
            return self._fit(target, candidate)[0]

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
        fits = [(*self._fit(target, candidate), candidate) for candidate in wrong]
        _, c, best = min(fits, key=lambda each: each[0])
        return best.to_effect(c)

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

    def _fit(self, target: Array, candidate: Candidate) -> tuple[float, Array]:
        """Squares of a target (n, q) not explained by iron and a candidate, and the candidate's coefficients (k,)."""
        both = np.concatenate([candidate.columns(self.problem), target[:, :, None]], axis=2)
        left = self._without_base(both.reshape(len(both), -1)).reshape(both.shape)
        N = products(without_rounding(left, both))
        c = solved(N)
        return squares_left(N, c), c


@dataclass(frozen=True, eq=False)
class HypothesisPair:
    """Two hypotheses on a recording: fitted effects, and candidate settings of each, which act throughout a leg.

    listed : whether the second is a look-alike; otherwise a change of the iron that the recording distinguishes from
    the first, and the leg must as well.
    """

    first: Effect
    second: Effect
    first_candidates: tuple[Candidate, ...]
    second_candidates: tuple[Candidate, ...]
    listed: bool

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
    """Pair a named effect with each rival that has a setting, as a body a place beside the path, fitted to it."""
    effect, window = cause.effect, cause.effect.active_s
    for name, may_be in _rivals(recording, cause).items():
        if rivals := recording.settings(name, effect, window):
            rival = recording.fitted(effect, rivals)
            settings = ([Candidate.of(effect), *recording.settings(cause.name, rival, window)], rivals)
            own, others = (tuple(one.at({ACTIVE_WINDOW.name: None}) for one in each) for each in settings)
            first, second = (replace(one, active_s=None) for one in (effect, rival))
            yield HypothesisPair(first, second, own, others, may_be)


def _rivals(recording: LegProblem, cause: NamedEffect) -> dict[str, bool]:
    """Look-alikes observable in another run, and beside those of iron all other changes of iron: whether listed."""
    may_recur = {name for name in recording.candidates if not BY_NAME[name].traits.one_run}
    likely = [name for name in cause.alternatives if {cause.name, name} <= may_recur]
    found = {name: True for name in likely if not are_equivalent(cause.name, name)}
    iron = iron_candidates() if found and cause.kind is EvidenceKind.IRON else ()
    return found | {name: False for name in iron if name not in (cause.name, *cause.alternatives)}


def are_equivalent(first: str, second: str) -> bool:
    """Whether `Traits.equivalent_to` states that two effects agree on every motion."""
    return BY_NAME[first].traits.equivalent_to == second or BY_NAME[second].traits.equivalent_to == first
