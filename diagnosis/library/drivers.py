"""Drivers: recorded channels that may cause a gap through an empirical curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import as_currents
from recordings.channels import SCALAR
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.channels import HIGHEST, LAGS_S, Late, curve_of, felt

ROUNDING, LEAST_RANGE = 1e-9, 1e-11
"""Relative range of a course below which the range is rounding, and least range in a channel's own unit."""


class Lag(NamedTuple):
    """Lag of a driver: time constant in s, applied to the channel or to its curve."""

    lag_s: float = 0.0
    late: Late = "channel"


AT_ONCE = Lag()
CHANNEL_LAGS = tuple(Lag(lag_s) for lag_s in LAGS_S)
"""The lag applied before the curve."""
LAGS = (*CHANNEL_LAGS, *(Lag(lag_s, "curve") for lag_s in LAGS_S if lag_s))


@dataclass(frozen=True, eq=False)
class Driver:
    """A named course x (n,) with its centre and half range, extremes excluded."""

    name: str
    x: Array
    centre: float
    half_range: float

    @classmethod
    def of(cls, name: str, x: Array, policy: Policy) -> Driver | None:
        """The driver of a course; None for a course with gaps, or constant but for rounding."""
        if not np.isfinite(x).all():
            return None
        tail, least = policy.driver_tail, max(ROUNDING * float(np.abs(x).max()), LEAST_RANGE)
        low, high = np.quantile(x, [tail, 1 - tail])
        if high - low <= least:
            low, high = x.min(), x.max()
        return cls(name, x, float(low + high) / 2, float(high - low) / 2) if high - low > least else None

    def terms(self, way: Lag, interval_s: float) -> Array:
        """Powers (n, 3) of the centred and scaled course, with a lag."""
        return felt((self.x - self.centre) / self.half_range, HIGHEST, way.late, way.lag_s, interval_s, {})

    def candidate(self, way: Lag, tried: int) -> Candidate:
        """The channel effect of this driver, of the highest order, selected among `tried` settings."""
        curve = curve_of(self.name, self.centre, self.half_range, way.lag_s, way.late)
        return replace(Candidate.of(curve), tried=tried)


def find_drivers(problem: LinearProblem) -> list[Driver]:
    """Every recorded channel that varies, except reference magnetometers and copies of motor currents."""
    others = {SCALAR, *as_currents(problem.recording).values()}
    courses = ((name, x) for name, x in problem.state.channels.items() if name not in others)
    return [driver for name, x in courses if (driver := Driver.of(name, x, problem.policy)) is not None]


def may_drive(effect: type[Effect], other: type[Effect]) -> bool:
    """Whether a slow effect driven by a channel may have the course of a slow effect of time."""
    return effect.traits.slow and bool(effect.needs) and other.traits.slow and not other.needs


def in_axes(unit: Array, terms: Array) -> Array:
    """Columns (n, q, 3 k) of terms (n, k) along each of three axes, unit (n, q, 3); the axes of a term are adjacent."""
    return np.asarray((unit[:, :, None, :] * terms[:, None, :, None]).reshape(*unit.shape[:2], -1))
