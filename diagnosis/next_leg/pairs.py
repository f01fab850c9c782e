"""Pairs of hypotheses for a leg to separate: a named effect with a look-alike, or with another change of iron."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.library.drivers import may_drive
from diagnosis.library.parameter_search import search_parameters
from diagnosis.next_leg.separation import LegProblem
from diagnosis.result import EvidenceKind, NamedEffect
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.parameters import ACTIVE_WINDOW, Window


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
        """Pair a named effect with a rival fitted to it; None for a rival without a setting, as a body without
        a place beside the path.
        """
        window = cause.effect.active_s
        rivals = _settings(recording, rival, cause.effect, window)
        if not rivals:
            return None
        second = recording.fitted(cause.effect, rivals)
        own = (Candidate.of(cause.effect), *_settings(recording, cause.name, second, window))
        permanent, permanent_rivals = (
            [candidate.at({ACTIVE_WINDOW.name: None}) for candidate in candidates] for candidates in (own, rivals)
        )
        first, second = (replace(effect, active_s=None) for effect in (cause.effect, second))
        return cls(first, second, tuple(permanent), tuple(permanent_rivals), listed)

    def separation_nats(self, leg: LegProblem) -> float:
        """Nats by which a leg separates both hypotheses, whichever is true; zero if the leg shows one of them only.

        Zero for a separation within the form error of a family, or of second order in a change of the iron; at most the
        total nats of the named effect on the leg. If one hypothesis contains the other, the simpler is preferred unless
        the leg shows more.
        """
        if not self._is_observable(leg):
            return 0.0
        size = leg.total_nats(self.first)
        nats = (
            [leg.missing_nats(self.first, self.second_candidates)]
            if self.first.name not in self.second.traits.contains
            else []
        )
        if self.listed and self.second.name not in self.first.traits.contains:
            nats.append(leg.missing_nats(self.second, self.first_candidates))
        smallest = min((size, *nats)) if nats else 0.0
        return smallest if smallest > self._form_share(leg) * size else 0.0

    def _is_observable(self, leg: LegProblem) -> bool:
        """Whether a leg holds the causes of both hypotheses; at rest all changes of the iron are one constant."""
        missing = any(leg.problem.missing_inputs(type(effect)) for effect in (self.first, self.second))
        return not missing and (leg.iron or leg.problem.turns)

    def _form_share(self, leg: LegProblem) -> float:
        """Share of an effect without information: a form error within a family, or terms of second order in the iron.

        Includes the part of a drift beyond a temperature of nearly the same course, as a temperature may act late or
        bent.
        """
        family = bool(self.first.traits.family) and self.first.traits.family == self.second.traits.family
        courses = may_drive(type(self.second), type(self.first)) or may_drive(type(self.first), type(self.second))
        policy = leg.problem.policy
        of_course = 1 - policy.nearly_all**2 if courses else 0.0
        return max(policy.same_family if family else 0.0, of_course, 0.0 if leg.iron else policy.same_iron)


def pairs_of(recording: LegProblem, cause: NamedEffect) -> Iterator[HypothesisPair]:
    """Pair a named effect with each look-alike observable in another run, and iron with all other changes of iron."""
    rivals = [
        (rival, True)
        for rival in cause.alternatives
        if _is_tried(recording, cause.name, rival) and not are_equivalent(cause.name, rival)
    ]
    if cause.kind is EvidenceKind.IRON:
        rivals += [(rival, False) for rival in iron_candidates() if rival not in (cause.name, *cause.alternatives)]
    for rival, listed in rivals:
        pair = HypothesisPair.of(recording, cause, rival, listed=listed)
        if pair is not None:
            yield pair


def are_equivalent(first: str, second: str) -> bool:
    """Whether `Traits.equivalent_to` states that two effects agree on every motion."""
    return BY_NAME[first].traits.equivalent_to == second or BY_NAME[second].traits.equivalent_to == first


def _is_tried(recording: LegProblem, first: str, second: str) -> bool:
    """Whether two hypotheses have columns and may recur in another run."""
    return all(name in recording.candidates and not BY_NAME[name].traits.one_run for name in (first, second))


def _settings(recording: LegProblem, name: str, true: Effect, window: Window) -> list[Candidate]:
    """Settings at which a candidate may resemble a true effect, in the window of the named effect."""
    listed = recording.candidates[name]
    candidates = [
        candidate.at({ACTIVE_WINDOW.name: window}) if window and candidate.can_have_window else candidate
        for candidate in listed
    ]
    return search_parameters(recording.problem, recording.without_base(recording.target(true)), candidates)
