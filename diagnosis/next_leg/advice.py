"""The leg that best separates named effects from their look-alikes, computed by the simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.next_leg.legs import CandidateLeg, legs_of, repeated
from diagnosis.next_leg.pairs import are_equivalent, pairs_of
from diagnosis.next_leg.separation import LegProblem
from diagnosis.next_leg.table import LegTable
from diagnosis.policy import Policy
from diagnosis.problem.blocks import BlockFit, Cut, block_sums, colour, sums
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patch_model
from diagnosis.result import Diagnosis, EvidenceKind, Flight
from scenarios.arrays import Array
from sim.effects.parameters import Window
from validation.text import digits, listed

MINUTE_S = 60.0
MOST_TIMES = 6
"""Largest number of flights of a leg in one scenario."""


def advised(diagnosis: Diagnosis) -> Diagnosis:
    """Add the leg to fly next to the advice of a diagnosis; unchanged where there is none."""
    flight_advice = advise_flight(diagnosis)
    remarks = [
        f"No leg that the simulator can fly distinguishes {listed([name, *others])}."
        for name, others in _inseparable_by_name(flight_advice)
    ]
    if flight_advice.next is None:
        return replace(diagnosis, advice=(*remarks, *diagnosis.advice)) if remarks else diagnosis
    return replace(
        diagnosis,
        advice=(f"Next, {flight_advice.next.words}.", *remarks, *diagnosis.advice),
        next_flight=flight_advice.next.flight,
    )


@dataclass(frozen=True, eq=False)
class NextFlight:
    """A leg, the least nats by which one flight separates a named effect from a look-alike, and the number of flights.

    window : time of action of the effect in the recording; on the leg the effect must act throughout.
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
        """The scenario for `magbench simulate`, with its figures."""
        scenario = repeated(self.leg, self.times)
        return Flight(scenario, self.name, self.other, self.leg.words, self.leg.duration_s, self.nats, self.needed_s)

    @property
    def words(self) -> str:
        """What to fly, for how long, and with which result."""
        minutes = self.leg.duration_s / MINUTE_S
        acting = (
            "" if self.window is None else ", with what acted from {:.0f} s to {:.0f} s at work".format(*self.window)
        )
        return (
            f"fly {self.leg.words}{acting} (next.toml): {digits(minutes)} min distinguish {self.name} from "
            f"{self.other} by {digits(self.nats)} nats, by the simulator; {_minutes(self.needed_s)} needed"
        )


@dataclass(frozen=True, eq=False)
class FlightAdvice:
    """The next flight, if any, and look-alikes separated by no leg: (name, look-alike)."""

    next: NextFlight | None
    inseparable: tuple[tuple[str, str], ...]


def advise_flight(diagnosis: Diagnosis) -> FlightAdvice:
    """Advise the leg that best separates a named effect from all its look-alikes, by the worse direction of each pair.

    Vector mode only, and only where the recording turns: a fixed station cannot fly.
    """
    if not diagnosis.problem.turns:
        return FlightAdvice(None, ())
    equivalent = tuple(
        (cause.name, look_alike)
        for cause in diagnosis.named
        for look_alike in cause.alternatives
        if are_equivalent(cause.name, look_alike)
    )
    tables = _leg_tables(diagnosis)
    best = [flight for cause in tables if (flight := _best_flight(cause, diagnosis.problem.policy)) is not None]
    inseparable = (*equivalent, *(pair for cause in tables for pair in cause.inseparable))
    return FlightAdvice(max(best, key=lambda cause: cause.nats, default=None), inseparable)


def _leg_tables(diagnosis: Diagnosis) -> list[LegTable]:
    """Separation by every leg of the model's vehicle, for each named effect with look-alikes."""
    permanent = patch_model(diagnosis.model, (), diagnosis.problem).chain()
    recordings = [
        LegProblem(diagnosis.problem, permanent, cause.kind is not EvidenceKind.IRON) for cause in diagnosis.named
    ]
    with_pairs = [
        (cause, recording, tuple(pairs_of(recording, cause)))
        for cause, recording in zip(diagnosis.named, recordings, strict=True)
    ]
    with_pairs = [row for row in with_pairs if any(pair.listed for pair in row[2])]
    if not with_pairs:
        return []
    V = _inflation_of(diagnosis.problem, diagnosis.after_nT / diagnosis.problem.sigma_nT)
    flown = [
        (leg, posed)
        for leg in legs_of(diagnosis.model)
        if (posed := leg.problem(diagnosis.problem, permanent)) is not None
    ]
    return [LegTable.of(cause, recording, pairs, flown, V) for cause, recording, pairs in with_pairs]


def _best_flight(table: LegTable, policy: Policy) -> NextFlight | None:
    """The best leg for a named effect, and the flying time."""
    best = table.best
    if best is None:
        return None
    leg, look_alike, nats = best
    times = int(np.clip(math.ceil(policy.leg_margin * policy.apart / nats), 1, MOST_TIMES))
    return NextFlight(
        table.cause.name,
        look_alike,
        leg,
        nats,
        leg.duration_s * policy.apart / nats,
        times,
        table.cause.effect.active_s,
    )


def _inseparable_by_name(flight_advice: FlightAdvice) -> list[tuple[str, list[str]]]:
    """Each name with the look-alikes separated by no leg, once for repeated names."""
    pairs = dict.fromkeys(flight_advice.inseparable)
    names = dict.fromkeys(name for name, _ in pairs)
    return [(name, [second for first, second in pairs if first == name]) for name in names]


def _minutes(seconds: float) -> str:
    return "less than one is" if seconds < MINUTE_S else f"{digits(seconds / MINUTE_S)} min are"


def _inflation_of(problem: LinearProblem, residual: Array) -> float:
    """Inflation by the colour of a residual (n, q) without any fit."""
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    no_columns = np.zeros((len(residual), residual.shape[1], 0))
    s = sums(cut, np.zeros((len(residual), 1)), no_columns, residual, np.ones(len(residual)))
    nothing = BlockFit(np.zeros((1, residual.shape[1])), np.zeros(0), np.zeros((0, 0)))
    return max(1.0, colour(block_sums(s, nothing), s.count, problem.policy))
