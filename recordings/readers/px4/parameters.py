"""Parameters of a PX4 log as they change with time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from recordings.readers.px4.contents import ULog
from scenarios.arrays import Array

TOGETHER_S = 0.5
"""Changes that follow each other within this time are one change: a vector's components are written one by one."""


@dataclass(frozen=True)
class ParameterState:
    """The values of parameters from a time on."""

    from_s: float
    values: Mapping[str, float]

    def number(self, name: str, default: float = 0.0) -> float:
        """Return a parameter; the default where the log does not hold a finite value."""
        value = self.values.get(name, default)
        return value if np.isfinite(value) else default

    def whole(self, name: str, default: int = 0) -> int:
        """Return a parameter that counts or chooses."""
        return round(self.number(name, default))

    def vector(self, pattern: str, default: float = 0.0) -> Array:
        """Return (3,) parameters whose names have X, Y, Z in place of {}."""
        return np.array([self.number(pattern.format(axis), default) for axis in "XYZ"])


def parameter_states(log: ULog, prefixes: tuple[str, ...]) -> list[ParameterState]:
    """Return the parameters that begin with one of the prefixes: at the start, and after each change within the log."""
    values = {name: value for name, value in log.parameters.items() if name.startswith(prefixes)}
    states = [ParameterState(-np.inf, dict(values))]
    for change in log.changes:
        if not change.name.startswith(prefixes) or values.get(change.name) == change.value:
            continue
        values[change.name] = change.value
        together = change.time_s - states[-1].from_s < TOGETHER_S and len(states) > 1
        start_s = states[-1].from_s if together else change.time_s
        states[-1 if together else len(states) :] = [ParameterState(start_s, dict(values))]
    return states
