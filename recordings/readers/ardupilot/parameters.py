"""The parameters of an autopilot as a log tells them: at the start, and at each change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class Parameters:
    """The values of every parameter in the order of the log.

    Parameters
    ----------
    names : of the parameter of each entry. times_s : (n,) when it was written. values : (n,).
    """

    names: list[str] = field(default_factory=list)
    times_s: Array = field(default_factory=lambda: np.zeros(0))
    values: Array = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def last(self) -> Mapping[str, float]:
        """The last value of each parameter, by its name."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    def __contains__(self, name: str) -> bool:
        """Whether the log gives the parameter."""
        return name in self.last

    def get(self, name: str, default: float = 0.0) -> float:
        """Return the last finite value of a parameter, else the default."""
        value = self.last.get(name, default)
        return value if np.isfinite(value) else default

    def vector(self, name: str, default: float = 0.0) -> Array:
        """Return the last values of NAME_X, NAME_Y, NAME_Z: (3,)."""
        return np.array([self.get(f"{name}_{axis}", default) for axis in "XYZ"])

    def changes_s(self, names: Iterable[str]) -> Array:
        """Return the times at which one of these parameters got another value than it had: ascending, (k,)."""
        times = [self.times_s[rows][1:][np.diff(self.values[rows]) != 0] for rows in map(self._rows, names)]
        return np.unique(np.concatenate([np.zeros(0), *times]))

    def at(self, time_s: float, names: Iterable[str]) -> Parameters:
        """Return these parameters as they were in force at a time: the first value before its own time as well."""
        found = {name: rows for name in names if len(rows := self._rows(name))}
        kept = [rows[max(int(np.searchsorted(self.times_s[rows], time_s, "right")) - 1, 0)] for rows in found.values()]
        return Parameters(list(found), self.times_s[kept], self.values[kept])

    def _rows(self, name: str) -> NDArray[np.int64]:
        """Return the entries of a parameter, by time."""
        rows = np.array(self._index.get(name, []), np.int64)
        return rows[np.argsort(self.times_s[rows], kind="stable")]

    @cached_property
    def _index(self) -> Mapping[str, list[int]]:
        found: dict[str, list[int]] = {}
        for row, name in enumerate(self.names):
            found.setdefault(name, []).append(row)
        return found
