"""What a leg must tell a name from: its look-alikes, and what else the iron is taken for; and by how much it does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from diagnosis.library.candidates import Candidate, changes_of_iron, missing_channels
from diagnosis.library.drivers import may_drive
from diagnosis.library.parameter_search import found_by_search
from diagnosis.next_leg.separation import Flown
from diagnosis.result import How, Named
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.parameters import ACTIVE_WINDOW, Window


@dataclass(frozen=True, eq=False)
class HypothesisPair:
    """Two hypotheses for the recording in hand: effects as found, and the settings that each may take on.

    On a leg both act all along. listed : whether the second is a look-alike; else it is a change of the iron that the
    recording in hand tells from the first, as the leg must too.
    """

    one: Effect
    second: Effect
    mine: tuple[Candidate, ...]
    others: tuple[Candidate, ...]
    listed: bool

    @classmethod
    def of(cls, hand: Flown, one: Named, other: str, *, listed: bool) -> HypothesisPair:
        """What was named, and another as it is fitted to what was named."""
        window = one.effect.active_s
        others = _settings(hand, other, one.effect, window)
        second = hand.fitted(one.effect, others)
        mine = (Candidate.of(one.effect), *_settings(hand, one.name, second, window))
        lasting, fitted = ([each.at({ACTIVE_WINDOW.name: None}) for each in some] for some in (mine, others))
        return cls(_lasting(one.effect), _lasting(second), tuple(lasting), tuple(fitted), listed)

    def apart(self, leg: Flown) -> float:
        """Nats by which the leg by itself tells the two apart, whichever of them is true; zero where it shows one only.

        Zero where that is no more than an error of form of one kin would make, or the second order of a change of the
        iron; no more than the leg shows of the name at all. Of two of which one makes the other too it is the simpler,
        unless the leg shows more.
        """
        if not self._is_shown(leg):
            return 0.0
        size = leg.size(self.one)
        told = [leg.lacks(self.one, self.others)] if self.one.name not in self.second.traits.contains else []
        if self.listed and self.second.name not in self.one.traits.contains:
            told.append(leg.lacks(self.second, self.mine))
        least = min((size, *told)) if told else 0.0
        return least if least > self._form(leg) * size else 0.0

    def _is_shown(self, leg: Flown) -> bool:
        """Whether a leg holds the causes of both; at rest every change of the iron is one constant."""
        missing = any(missing_channels(type(each), leg.problem) for each in (self.one, self.second))
        return not missing and (leg.iron or leg.problem.turns)

    def _form(self, leg: Flown) -> float:
        """The part of an effect that says nothing: an error of form within a kin, the second order in the iron.

        So is what a drift has beyond a temperature of nearly its course, which may be felt late or in a curve.
        """
        kin = bool(self.one.traits.family) and self.one.traits.family == self.second.traits.family
        courses = may_drive(type(self.second), type(self.one)) or may_drive(type(self.one), type(self.second))
        policy = leg.problem.policy
        of_course = 1 - policy.one_course**2 if courses else 0.0
        return max(policy.same_kin if kin else 0.0, of_course, 0.0 if leg.iron else policy.same_iron)


def pairs_of(hand: Flown, one: Named) -> Iterator[HypothesisPair]:
    """A name beside each look-alike that another run can show, and for a change of the iron beside all others."""
    for other in one.alternatives:
        if _is_tried(hand, one.name, other) and not are_twins(one.name, other):
            yield HypothesisPair.of(hand, one, other, listed=True)
    if one.how is How.IRON:
        for other in changes_of_iron():
            if other not in (one.name, *one.alternatives):
                yield HypothesisPair.of(hand, one, other, listed=False)


def are_twins(one: str, other: str) -> bool:
    """Whether one effect says of itself that it is the other on every motion."""
    return BY_NAME[one].traits.equivalent_to == other or BY_NAME[other].traits.equivalent_to == one


def _is_tried(hand: Flown, one: str, other: str) -> bool:
    """Whether two hypotheses have columns, and hold for another run."""
    return all(name in hand.candidates and not BY_NAME[name].traits.one_run for name in (one, other))


def _settings(hand: Flown, name: str, true: Effect, window: Window) -> list[Candidate]:
    """The settings at which a candidate may look like a true effect, in the window of what was named."""
    listed = hand.candidates[name]
    members = [one.at({ACTIVE_WINDOW.name: window}) if window and one.may_be_switched else one for one in listed]
    return found_by_search(hand.problem, hand.without_base(hand.target(true)), members)


def _lasting(effect: Effect) -> Effect:
    """The effect without its window."""
    values: dict[str, Any] = {p.name: getattr(effect, p.name) for p in effect.parameters()}
    return type(effect)(**values)
