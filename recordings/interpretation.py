"""A foreign log's columns as a recording's: names, then units that neither names nor options tell, in one line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.columns import ACCEL, GYRO, mag_names
from recordings.likely_units import accel_factor, field_unit, gyro_unit, stamp_unit, time_unit
from recordings.reading import COUNT, Reading
from recordings.units import UNITS, ColumnMap
from scenarios.arrays import Array

OWN_UNITS = {"time": "s", "mag": "nT", "gyro": "rad/s", "accel": "m/s^2", "temperature": "degC"}

SECONDS_1970 = (3e8, 1e10)
"""Times in s between these count from 1970: from 1979 on; a clock that counts from a start runs for less than years."""


@dataclass
class Interpretation:
    """Columns under a recording's names while their units are settled.

    named : name -> (n,) values, in the unit of the map, or as in the file where the map says none.
    start_s : seconds since 1970 at time_s = 0, where the stamps count from 1970.
    all_maps : and those of them whose names were guessed. parts : what is said of each quantity.
    """

    named: dict[str, NDArray[Any]]
    all_maps: Sequence[ColumnMap]
    guesses: Sequence[ColumnMap]
    reading: Reading
    unit: str = "nT"
    timed: bool = True
    axes: str = "xyz"
    start_s: float | None = None
    parts: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Sort the maps by target; columns of `--mag` without a unit count as guessed."""
        self.maps = {one.target: one for one in self.all_maps if one.target in self.named}
        of_mag = [one for one in self.all_maps if one.source in self.reading.mag]
        self.guessed = frozenset(one.target for one in (*self.guesses, *of_mag))

    @property
    def sources(self) -> dict[str, str]:
        """The name in the file of each renamed column."""
        return {target: one.source for target, one in self.maps.items()}

    def settle(self) -> None:
        """Settle the units of field, time, specific force and rate, in this order."""
        self._fill()
        self._field()
        self.start_s = _start_s(self.named["time_s"]) if self.timed else None
        self._time()
        self._accel()
        self._gyro()
        for name in ("att_qw", "temperature_degC"):
            if name in self.guessed and name in self.named:
                self.parts.append(f"{name} = {self.maps[name].source}")

    @property
    def line(self) -> tuple[str, ...]:
        """How the log is read, in one line; empty where nothing was guessed."""
        if not self.parts:
            return ()
        frame = self.reading.frame or "flu, assumed (--frame frd turns it)"
        return (f"read as: {', '.join(self.parts)}; frame {frame}",)

    def _fill(self) -> None:
        """Add a time where none was logged, and zeros for a z that was not measured."""
        x, _, z = self.field
        if z not in self.named:
            self.named[z], self.axes = np.zeros(len(self.named[x])), "xy"
            self.notes.append("x and y alone were measured: z is filled with zeros, methods for the plane apply")
        if "time_s" not in self.named:
            self.named["time_s"], self.timed = np.arange(len(self.named[x]), dtype=np.float64), False
            self.notes.append(
                "no time was found (name it with --map time_s=COLUMN): methods that need times do not apply"
            )

    @property
    def field(self) -> tuple[str, ...]:
        """The columns of the magnetometer, of an array's first."""
        return mag_names() if mag_names()[0] in self.named else mag_names(1)

    def _field(self) -> None:
        """Settle the field's unit: as stated, by the name, or by the values; under a recording's names nT."""
        names = self.field[: len(self.axes)]
        entry, guessed = self.maps.get(names[0]), set(names) <= self.guessed
        unit, how = entry.unit if entry is not None else None, "by the name"
        if self.reading.unit is not None and self.reading.unit != unit:
            unit, how = self._rescaled(names, self.reading.unit, unit), "as stated"
        elif unit is None and guessed:
            unit, how = self._rescaled(names, field_unit(self._block(names))), "by the values"
        self.unit = {None: self.unit, COUNT: COUNT}.get(unit, "nT")
        if guessed:
            said = "counts of unknown unit" if unit == COUNT else unit
            self.parts.append(f"mag = {self._sources(names)} ({said}, {how})")

    def _rescaled(self, names: Sequence[str], unit: str, before: str | None = None) -> str:
        factor = UNITS["mag"].get(unit, (1.0, 0.0))[0] / UNITS["mag"].get(before or "nT", (1.0, 0.0))[0]
        self._scale(names, factor)
        return unit

    def _time(self) -> None:
        """Settle the unit of time: as mapped, since 1970 by the size, else by the rate at which the field turns."""
        entry, stamps = self.maps.get("time_s"), self.named["time_s"]
        unit = entry.unit if entry is not None else None
        guessed = entry is not None and "time_s" in self.guessed
        if self.timed and unit is None:
            unit = stamp_unit(stamps) or self._turning_unit(stamps, guessed)
            self.named["time_s"] = _seconds(stamps, unit)
            if entry is None and unit != "s":
                self.notes.append(f"time_s is in {unit} since 1970, and read so")
        if entry is not None and guessed:
            self.parts.insert(0, f"time_s = {entry.source} ({unit})")

    def _turning_unit(self, stamps: Array, guessed: bool) -> str:
        return time_unit(stamps, self._block(self.field[: len(self.axes)])) if guessed else "s"

    def _accel(self) -> None:
        if not set(ACCEL) <= self.guessed & set(self.named):
            return
        unit = self.maps[ACCEL[0]].unit
        if unit is None:
            factor, unit = accel_factor(self._block(ACCEL))
            if not factor:
                self._leave(ACCEL, "is never gravity's: without a unit")
                return
            self._scale(ACCEL, factor)
        self.parts.append(f"accel = {self._sources(ACCEL)} ({unit})")

    def _gyro(self) -> None:
        if not set(GYRO) <= self.guessed & set(self.named):
            return
        unit = self.maps[GYRO[0]].unit
        if unit is None:
            block = self._block(self.field[: len(self.axes)])
            unit = gyro_unit(self._block(GYRO), block, self.named["time_s"]) if self.timed else None
            if unit is None:
                self._leave(GYRO, "does not turn as the field does: without a unit")
                return
            self._scale(GYRO, UNITS["gyro"][unit][0])
        self.parts.append(f"gyro = {self._sources(GYRO)} ({unit})")

    def _leave(self, names: Sequence[str], why: str) -> None:
        """Keep a vector of unknown unit as channels."""
        sources = [self.maps[name].source for name in names]
        for name, source in zip(names, sources, strict=True):
            self.named[source] = self.named.pop(name)
            self.maps.pop(name)
        self.notes.append(f"{', '.join(sources)} {why}, left as channels (--map {names[0]}={sources[0]},unit=…)")

    def _block(self, names: Sequence[str]) -> Array:
        return np.column_stack([self.named[name] for name in names])

    def _scale(self, names: Sequence[str], factor: float) -> None:
        if factor != 1.0:
            self.named |= {name: factor * self.named[name] for name in names}

    def _sources(self, names: Sequence[str]) -> str:
        return ", ".join(self.maps[name].source for name in names)


def _seconds(stamps: Array, unit: str) -> Array:
    """Return stamps in seconds, from the first on where they count from 1970: seconds then keep their decimals."""
    if unit == "s":
        return stamps
    start = stamps[np.isfinite(stamps)][0] if stamp_unit(stamps) is not None else 0.0
    return np.asarray((stamps - start) * UNITS["time"][unit][0])


def _start_s(stamps: Array) -> float | None:
    """Return seconds since 1970 at time_s = 0, of stamps that count from 1970; None for other times."""
    finite, unit = stamps[np.isfinite(stamps)], stamp_unit(stamps)
    if unit is not None:
        return float(finite[0]) * UNITS["time"][unit][0]
    return 0.0 if len(finite) and SECONDS_1970[0] < finite[0] < SECONDS_1970[1] else None


def without_unit(entry: ColumnMap) -> ColumnMap:
    """Return a map that leaves counts as they are."""
    return replace(entry, unit=None) if entry.unit == COUNT else entry
