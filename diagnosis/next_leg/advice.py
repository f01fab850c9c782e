"""The leg that best separates named effects from their look-alikes, computed by the simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.next_leg.legs import CandidateLeg, flown_legs
from diagnosis.next_leg.pairs import HypothesisPair, LegProblem, are_equivalent, pairs_of
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut, colour
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patch_model
from diagnosis.result import Diagnosis, EvidenceKind, Flight, NamedEffect
from scenarios.arrays import Array
from validation.text import digits, listed

MINUTE_S = 60.0
MOST_TIMES = 6
"""Largest number of flights of a leg in one scenario."""


def advised(diagnosis: Diagnosis) -> Diagnosis:
    """Add the leg to fly next to the advice of a diagnosis, and the look-alikes separated by no leg.

    Vector mode only, and only where the recording turns: a fixed station cannot fly.
    """
    if not diagnosis.problem.turns:
        return diagnosis
    tables = leg_tables(diagnosis)
    alike = _inseparable(diagnosis.named, tables)
    remarks = [f"No leg that the simulator can fly distinguishes {listed([name, *alike[name]])}." for name in alike]
    advice = (*remarks, *diagnosis.advice)
    flights = [(flight, table.cause) for table in tables if (flight := table.flight) is not None]
    if not flights:
        return replace(diagnosis, advice=advice)
    flight, cause = max(flights, key=lambda one: one[0].nats)
    return replace(diagnosis, advice=(f"Next, {_words(flight, cause)}.", *advice), next_flight=flight)


def _inseparable(named: Sequence[NamedEffect], tables: Sequence[LegTable]) -> dict[str, list[str]]:
    """By name, the look-alikes that agree with it on every motion, or are separated by no leg."""
    pairs = [(one.name, other) for one in named for other in one.alternatives if are_equivalent(one.name, other)]
    pairs += [(table.cause.name, other) for table in tables for other in table.inseparable]
    alike: dict[str, list[str]] = {}
    for name, other in dict.fromkeys(pairs):
        alike.setdefault(name, []).append(other)
    return alike


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
        """Look-alikes separated by no leg."""
        return [pair.second.name for i, pair in enumerate(self.pairs) if pair.listed and i not in self.separable]

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
    """Separation by every leg of the model's vehicle, for each named effect with look-alikes."""
    problem = diagnosis.problem
    permanent = patch_model(diagnosis.model, (), problem).chain()
    of_causes = []
    for cause in diagnosis.named:
        recording = LegProblem(problem, permanent, iron=cause.kind is not EvidenceKind.IRON)
        pairs = list(pairs_of(recording, cause))
        if any(pair.listed for pair in pairs):
            of_causes.append((recording, cause, pairs))
    flown = flown_legs(diagnosis.model, problem, permanent) if of_causes else []
    V, legs = inflation_of(problem, diagnosis.after_nT / problem.sigma_nT), [leg for leg, _ in flown]
    tables = []
    for recording, cause, pairs in of_causes:
        on_legs = [replace(recording, problem=posed) for _, posed in flown]
        nats = np.array([[pair.separation_nats(leg) / V for leg in on_legs] for pair in pairs])
        tables.append(LegTable(cause, pairs, legs, nats, problem.policy))
    return tables


def inflation_of(problem: LinearProblem, residual: Array) -> float:
    """Inflation of nats by the colour of a residual (n, q), at least 1."""
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    return max(1.0, colour(cut.blocks(residual).sum(axis=1), np.full(cut.m, cut.length), problem.policy))


def _words(flight: Flight, cause: NamedEffect) -> str:
    """What to fly, for how long, and with which result; what acted in a part of the run must act throughout."""
    window = cause.effect.active_s
    acting = "" if window is None else ", with what acted from {:.0f} s to {:.0f} s at work".format(*window)
    needed = "less than one is" if flight.needed_s < MINUTE_S else f"{digits(flight.needed_s / MINUTE_S)} min are"
    return (
        f"fly {flight.leg}{acting} (next.toml): {digits(flight.leg_s / MINUTE_S)} min distinguish {flight.name} from "
        f"{flight.other} by {digits(flight.nats)} nats, by the simulator; {needed} needed"
    )
