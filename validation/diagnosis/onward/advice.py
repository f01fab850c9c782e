"""The leg that separates what was named from its look-alikes most, computed by the simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.library.candidates import Candidate, changes_of_iron, missing_channels, proposed
from validation.diagnosis.onward.legs import Leg, legs_of, repeated
from validation.diagnosis.onward.separation import Experiment
from validation.diagnosis.problem.blocks import Cut, Fit, block_sums, colour, sums
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.repair.model import patched
from validation.diagnosis.result import Diagnosis, Flight, How, Named
from validation.text import digits, listed

MINUTE_S = 60.0
MOST_TIMES = 6
"""Flights of a leg at most that a scenario holds."""


def advised(found: Diagnosis) -> Diagnosis:
    """The diagnosis with the leg to fly next, first among its advice; as it is where there is none."""
    told = onward(found)
    same = [
        f"No leg that the simulator can fly tells {listed([name, *others])} apart." for name, others in _by_name(told)
    ]
    if told.next is None:
        return replace(found, advice=(*same, *found.advice)) if same else found
    return replace(found, advice=(f"Next, {told.next.words}.", *same, *found.advice), onward=told.next.flight)


@dataclass(frozen=True, eq=False)
class Next:
    """A leg, the nats by which one flight of it tells a name from a look-alike at least, and how often to fly it."""

    name: str
    other: str
    leg: Leg
    nats: float
    needed_s: float
    times: int

    @property
    def flight(self) -> Flight:
        """What `magbench simulate` flies, with its figures."""
        scenario = repeated(self.leg, self.times)
        return Flight(scenario, self.name, self.other, self.leg.words, self.leg.duration_s, self.nats, self.needed_s)

    @property
    def words(self) -> str:
        """What to fly, for how long, and what it brings."""
        minutes = self.leg.duration_s / MINUTE_S
        return (
            f"fly {self.leg.words} (next.toml): {digits(minutes)} min tell {self.name} from {self.other} by "
            f"{digits(self.nats)} nats, by the simulator; {_minutes(self.needed_s)} needed"
        )


@dataclass(frozen=True, eq=False)
class Onward:
    """What to fly next, if anything, and look-alikes that no leg tells apart: (name, the other)."""

    next: Next | None
    same: tuple[tuple[str, str], ...]


def onward(found: Diagnosis) -> Onward:
    """The leg that separates a name from a look-alike most, by the worse of the two directions.

    In vector mode and where the recording turns: a fixed station is not told to fly.
    """
    if not found.problem.turns:
        return Onward(None, ())
    twins, pairs = _pairs(found)
    if not pairs:
        return Onward(None, twins)
    always = patched(found.model, (), found.problem).chain()
    legs = [(leg, posed) for leg in legs_of(found.model) if (posed := leg.problem(found.problem, always)) is not None]
    most = [_best(found, one, other, always, legs) for one, other in pairs]
    told = [one for one in most if one is not None]
    least = found.problem.policy.least_leg_nats
    same = (*twins, *((one.name, one.other) for one in told if one.nats < least))
    return Onward(max((one for one in told if one.nats >= least), key=lambda one: one.nats, default=None), same)


def _by_name(told: Onward) -> list[tuple[str, list[str]]]:
    """Each name with the look-alikes that no leg tells from it."""
    names = dict.fromkeys(name for name, _ in told.same)
    return [(name, [other for one, other in told.same if one == name]) for name in names]


def _minutes(seconds: float) -> str:
    return "less than one is" if seconds < MINUTE_S else f"{digits(seconds / MINUTE_S)} min are"


def _pairs(found: Diagnosis) -> tuple[tuple[tuple[str, str], ...], list[tuple[Named, str]]]:
    """Names and look-alikes: those that are one on every motion, and those that a leg may tell apart."""
    every = [(one, other) for one in found.named for other in one.alternatives if _is_tried(one, other, found.problem)]
    twins = [(one.name, other) for one, other in every if _are_twins(one.name, other)]
    return tuple(twins), [(one, other) for one, other in every if (one.name, other) not in twins]


def _are_twins(one: str, other: str) -> bool:
    """Whether one effect says of itself that it is the other on every motion."""
    return BY_NAME[one].clues.same_as == other or BY_NAME[other].clues.same_as == one


def _best(
    found: Diagnosis, one: Named, other: str, always: tuple[Effect, ...], legs: Sequence[tuple[Leg, LinearProblem]]
) -> Next | None:
    """The leg that separates two hypotheses most; None where no leg shows both."""
    policy, V = found.problem.policy, _inflation_of(found.problem, found.after_nT / found.problem.sigma_nT)
    told = []
    for leg, posed in legs:
        if not missing_channels(type(one.effect), posed) and not missing_channels(BY_NAME[other], posed):
            experiment = Experiment(found.problem, posed, always, iron=one.how is not How.IRON)
            told.append((_apart(experiment, one, other) / V, leg))
    if not told:
        return None
    nats, leg = max(told, key=lambda pair: pair[0])
    share = max(nats, 1e-9) / policy.apart
    times = int(np.clip(math.ceil(policy.leg_margin / share), 1, MOST_TIMES))
    return Next(one.name, other, leg, nats, leg.duration_s / share, times)


def _apart(experiment: Experiment, one: Named, other: str) -> float:
    """Nats by which the leg tells two effects apart, whichever of them is true.

    None of those of one kin where that is no more than an error of their form would make.
    """
    wrong = _candidates(experiment.hand, other)
    second = experiment.fitted(one.effect, wrong)
    mine = [_as_candidate(one.effect), *_candidates(experiment.hand, one.name)]
    lacks = min(experiment.lacks(one.effect, wrong), experiment.lacks(second, mine))
    kin = bool(one.effect.clues.kin) and one.effect.clues.kin == BY_NAME[other].clues.kin
    form = experiment.hand.policy.same_kin * experiment.evidence(one.effect) if kin else 0.0
    return lacks if lacks > form else 0.0


def _candidates(problem: LinearProblem, name: str) -> list[Candidate]:
    return (changes_of_iron() | proposed(problem))[name]


def _as_candidate(effect: Effect) -> Candidate:
    """An effect as found, its linear parameters free."""
    free = {*effect.linear, *effect.tangents}
    rest = tuple((name, getattr(effect, name)) for name in effect.names() if name not in free)
    return Candidate(type(effect), rest, forms=effect.forms_in_use[1:])


def _is_tried(one: Named, other: str, problem: LinearProblem) -> bool:
    """Whether two hypotheses have columns that need no search, and hold for another run."""
    both = (one.name, other)
    known = all(name in changes_of_iron() or name in proposed(problem) for name in both)
    free = all(BY_NAME[name].sought() in (None, "origin") for name in both)
    return known and free and one.effect.active_s is None


def _inflation_of(problem: LinearProblem, left: Array) -> float:
    """Inflation by colour of a residual (n, q) that nothing more is fitted to."""
    cut = Cut.of(len(left), problem.state.interval_s, problem.policy)
    none = np.zeros((len(left), left.shape[1], 0))
    s = sums(cut, np.zeros((len(left), 1)), none, left, np.ones(len(left)))
    nothing = Fit(np.zeros((1, left.shape[1])), np.zeros(0), np.zeros((0, 0)))
    return max(1.0, colour(block_sums(s, nothing), s.count, problem.policy))
