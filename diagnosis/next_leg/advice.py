"""The leg that separates what was named from its look-alikes most, computed by the simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.next_leg.legs import CandidateLeg, legs_of, repeated
from diagnosis.next_leg.pairs import are_twins, pairs_of
from diagnosis.next_leg.separation import Flown
from diagnosis.next_leg.table import LegTable
from diagnosis.policy import Policy
from diagnosis.problem.blocks import BlockFit, Cut, block_sums, colour, sums
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patched
from diagnosis.result import Diagnosis, Flight, How
from scenarios.arrays import Array
from sim.effects.parameters import Window
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
class NextFlight:
    """A leg, the nats by which one flight of it tells a name from a look-alike at least, and how often to fly it.

    window : in which the effect acted, where that was a part of the run; on the leg it is to act all along.
    """

    name: str
    other: str
    leg: CandidateLeg
    nats: float
    needed_s: float
    times: int
    window: Window = None

    @property
    def flight(self) -> Flight:
        """What `magbench simulate` flies, with its figures."""
        scenario = repeated(self.leg, self.times)
        return Flight(scenario, self.name, self.other, self.leg.words, self.leg.duration_s, self.nats, self.needed_s)

    @property
    def words(self) -> str:
        """What to fly, for how long, and what it brings."""
        minutes = self.leg.duration_s / MINUTE_S
        acting = (
            "" if self.window is None else ", with what acted from {:.0f} s to {:.0f} s at work".format(*self.window)
        )
        return (
            f"fly {self.leg.words}{acting} (next.toml): {digits(minutes)} min tell {self.name} from {self.other} by "
            f"{digits(self.nats)} nats, by the simulator; {_minutes(self.needed_s)} needed"
        )


@dataclass(frozen=True, eq=False)
class FlightAdvice:
    """What to fly next, if anything, and look-alikes that no leg tells apart: (name, the other)."""

    next: NextFlight | None
    same: tuple[tuple[str, str], ...]


def onward(found: Diagnosis) -> FlightAdvice:
    """The leg that by itself tells a name from all its look-alikes best, by the worse of the two directions of each.

    In vector mode and where the recording turns: a fixed station is not told to fly.
    """
    if not found.problem.turns:
        return FlightAdvice(None, ())
    twins = tuple((one.name, other) for one in found.named for other in one.alternatives if are_twins(one.name, other))
    tables = _tables(found)
    best = [leg for one in tables if (leg := _next_of(one, found.problem.policy)) is not None]
    same = (*twins, *(pair for one in tables for pair in one.same))
    return FlightAdvice(max(best, key=lambda one: one.nats, default=None), same)


def _tables(found: Diagnosis) -> list[LegTable]:
    """What every leg that the model's vehicle can fly tells of each name that has look-alikes."""
    always = patched(found.model, (), found.problem).chain()
    hands = [Flown(found.problem, always, one.how is not How.IRON) for one in found.named]
    asked = [(one, hand, tuple(pairs_of(hand, one))) for one, hand in zip(found.named, hands, strict=True)]
    asked = [each for each in asked if any(pair.listed for pair in each[2])]
    if not asked:
        return []
    V = _inflation_of(found.problem, found.after_nT / found.problem.sigma_nT)
    flown = [(leg, posed) for leg in legs_of(found.model) if (posed := leg.problem(found.problem, always)) is not None]
    return [LegTable.of(one, hand, pairs, flown, V) for one, hand, pairs in asked]


def _next_of(table: LegTable, policy: Policy) -> NextFlight | None:
    """The best leg of a name, and how long it is to be flown."""
    found = table.best
    if found is None:
        return None
    leg, other, nats = found
    times = int(np.clip(math.ceil(policy.leg_margin * policy.apart / nats), 1, MOST_TIMES))
    return NextFlight(
        table.one.name, other, leg, nats, leg.duration_s * policy.apart / nats, times, table.one.effect.active_s
    )


def _by_name(told: FlightAdvice) -> list[tuple[str, list[str]]]:
    """Each name with the look-alikes that no leg tells from it, once where two of the name have them."""
    pairs = dict.fromkeys(told.same)
    names = dict.fromkeys(name for name, _ in pairs)
    return [(name, [other for one, other in pairs if one == name]) for name in names]


def _minutes(seconds: float) -> str:
    return "less than one is" if seconds < MINUTE_S else f"{digits(seconds / MINUTE_S)} min are"


def _inflation_of(problem: LinearProblem, left: Array) -> float:
    """Inflation by colour of a residual (n, q) that nothing more is fitted to."""
    cut = Cut.of(len(left), problem.state.interval_s, problem.policy)
    none = np.zeros((len(left), left.shape[1], 0))
    s = sums(cut, np.zeros((len(left), 1)), none, left, np.ones(len(left)))
    nothing = BlockFit(np.zeros((1, left.shape[1])), np.zeros(0), np.zeros((0, 0)))
    return max(1.0, colour(block_sums(s, nothing), s.count, problem.policy))
