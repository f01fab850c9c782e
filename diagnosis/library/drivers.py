"""What may drive a gap by a curve that no law says: every recorded channel, and as rivals the motion itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.actuators import as_currents
from diagnosis.problem.linear import LinearProblem
from recordings.channels import SCALAR
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.channels import HIGHEST, ChannelEffect, Late, felt

LAGS_S: tuple[float, ...] = ChannelEffect.search["lag_s"]
ROUNDING, LEAST_RANGE = 1e-9, 1e-11
"""Part of a course's size up to which its range is rounding, and the least range in a channel's own unit."""


class Way(NamedTuple):
    """How a channel is felt: with a lag, of the channel or of its curve."""

    lag_s: float = 0.0
    late: Late = "channel"


AT_ONCE = Way()
EARLY = tuple(Way(lag_s) for lag_s in LAGS_S)
"""The lag before the curve."""
WAYS = (*EARLY, *(Way(lag_s, "curve") for lag_s in LAGS_S if lag_s))


@dataclass(frozen=True, eq=False)
class Driver:
    """A course x (n,) by its name, its middle and half its range but for its extremes."""

    name: str
    x: Array
    centre: float
    half_range: float

    @classmethod
    def of(cls, name: str, x: Array, policy: Policy) -> Driver | None:
        """The driver of a course; None for one that is not known throughout, or does not move but by rounding."""
        if not np.isfinite(x).all():
            return None
        tail, least = policy.driver_tail, max(ROUNDING * float(np.abs(x).max()), LEAST_RANGE)
        low, high = np.quantile(x, [tail, 1 - tail])
        if high - low <= least:
            low, high = x.min(), x.max()
        return cls(name, x, float(low + high) / 2, float(high - low) / 2) if high - low > least else None

    def terms(self, way: Way, interval_s: float) -> Array:
        """The powers (n, 3) of the course, centred and scaled, as they are felt."""
        return felt((self.x - self.centre) / self.half_range, HIGHEST, way.late, way.lag_s, interval_s, {})

    def candidate(self, way: Way, tried: int) -> Candidate:
        """The effect that it drives, of the highest order, the best of so many."""
        one = ChannelEffect(self.name, self.centre, self.half_range, HIGHEST, lag_s=way.lag_s, late=way.late)
        return Candidate(ChannelEffect, tuple(_not_linear(one).items()), tried)


def drivers(problem: LinearProblem) -> list[Driver]:
    """Every recorded channel that moves, but another magnetometer, and a current that is a channel of the log too."""
    others = {SCALAR, *as_currents(problem.recording).values()}
    return _known((item for item in problem.state.channels.items() if item[0] not in others), problem.policy)


def may_drive(effect: type[Effect], other: type[Effect]) -> bool:
    """Whether a slow effect that a channel drives may have the course of a slow one in time."""
    return effect.traits.slow and bool(effect.needs) and other.traits.slow and not other.needs


def in_axes(unit: Array, terms: Array) -> Array:
    """Columns (n, q, 3 k) of terms (n, k) along each axis of the sensor, unit (n, q, 3); those of one term together."""
    return np.asarray((unit[:, :, None, :] * terms[:, None, :, None]).reshape(*unit.shape[:2], -1))


def _known(items: Iterator[tuple[str, Array]], policy: Policy) -> list[Driver]:
    return [one for name, x in items if (one := Driver.of(name, x, policy)) is not None]


def _not_linear(effect: ChannelEffect) -> dict[str, object]:
    return {p.name: getattr(effect, p.name) for p in effect.parameters() if p.name not in effect.linear}
