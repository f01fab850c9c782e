"""Separation of a named effect from its look-alikes by every leg, and the best leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.next_leg.legs import CandidateLeg
from diagnosis.next_leg.pairs import HypothesisPair
from diagnosis.next_leg.separation import LegProblem
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import NamedEffect
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class LegTable:
    """A named effect, p pairs, l legs, and the nats (p, l) by which each leg separates each pair."""

    cause: NamedEffect
    pairs: tuple[HypothesisPair, ...]
    legs: tuple[CandidateLeg, ...]
    nats: Array
    least_nats: float

    @classmethod
    def of(
        cls,
        cause: NamedEffect,
        recording: LegProblem,
        pairs: tuple[HypothesisPair, ...],
        legs: Sequence[tuple[CandidateLeg, LinearProblem]],
        V: float,
    ) -> LegTable:
        """Fill the table with legs flown by the simulator; V : inflation of the nats."""
        flown = [replace(recording, problem=posed) for _, posed in legs]
        nats = np.array([[pair.separation_nats(leg) / V for leg in flown] for pair in pairs]).reshape(
            len(pairs), len(legs)
        )
        return cls(cause, pairs, tuple(leg for leg, _ in legs), nats, recording.problem.policy.least_leg_nats)

    @property
    def separable(self) -> list[int]:
        """Indices of pairs separated by some leg."""
        return [i for i, of_pair in enumerate(self.nats) if of_pair.max(initial=0.0) >= self.least_nats]

    @property
    def inseparable(self) -> tuple[tuple[str, str], ...]:
        """Look-alikes separated by no leg: (name, look-alike)."""
        inseparable = set(range(len(self.pairs))) - set(self.separable)
        return tuple((self.cause.name, self.pairs[i].second.name) for i in sorted(inseparable) if self.pairs[i].listed)

    @property
    def best(self) -> tuple[CandidateLeg, str, float] | None:
        """The leg with the largest nats for its least separated pair, the nearest look-alike there, and nats."""
        listed = [i for i in self.separable if self.pairs[i].listed]
        if not listed:
            return None
        best = int(np.argmax(self.nats[self.separable].min(axis=0)))
        nearest = min(listed, key=lambda i: float(self.nats[i, best]))
        nats = float(self.nats[nearest, best])
        return (self.legs[best], self.pairs[nearest].second.name, nats) if nats >= self.least_nats else None
