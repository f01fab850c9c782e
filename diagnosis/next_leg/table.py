"""What each leg tells of a name: nats by look-alike and leg, and the leg that serves best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.next_leg.legs import CandidateLeg
from diagnosis.next_leg.pairs import HypothesisPair
from diagnosis.next_leg.separation import Flown
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Named
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class LegTable:
    """A name, p pairs of it with another, l legs, and the nats (p, l) by which each leg tells the two apart."""

    one: Named
    pairs: tuple[HypothesisPair, ...]
    legs: tuple[CandidateLeg, ...]
    nats: Array
    least_nats: float

    @classmethod
    def of(
        cls,
        one: Named,
        hand: Flown,
        pairs: tuple[HypothesisPair, ...],
        legs: Sequence[tuple[CandidateLeg, LinearProblem]],
        V: float,
    ) -> LegTable:
        """The table of legs as the simulator flies them; V : inflation of the nats."""
        flown = [replace(hand, problem=posed) for _, posed in legs]
        nats = np.array([[pair.apart(leg) / V for leg in flown] for pair in pairs]).reshape(len(pairs), len(legs))
        return cls(one, pairs, tuple(leg for leg, _ in legs), nats, hand.problem.policy.least_leg_nats)

    @property
    def told(self) -> list[int]:
        """The pairs that some leg tells apart."""
        return [i for i, some in enumerate(self.nats) if some.max(initial=0.0) >= self.least_nats]

    @property
    def same(self) -> tuple[tuple[str, str], ...]:
        """Look-alikes that no leg tells apart: (name, the other)."""
        left = set(range(len(self.pairs))) - set(self.told)
        return tuple((self.one.name, self.pairs[i].second.name) for i in sorted(left) if self.pairs[i].listed)

    @property
    def best(self) -> tuple[CandidateLeg, str, float] | None:
        """The leg that tells the name best from what it tells it from least, the nearest look-alike there, and nats."""
        listed = [i for i in self.told if self.pairs[i].listed]
        if not listed:
            return None
        best = int(np.argmax(self.nats[self.told].min(axis=0)))
        nearest = min(listed, key=lambda i: float(self.nats[i, best]))
        nats = float(self.nats[nearest, best])
        return (self.legs[best], self.pairs[nearest].second.name, nats) if nats >= self.least_nats else None
