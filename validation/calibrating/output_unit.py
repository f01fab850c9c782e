"""Offset and matrix in another unit than nT, as for firmware that works in counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib import Calibration
from recordings.columns import mag_names
from recordings.reading import COUNT, Reading
from recordings.units import UNITS
from scenarios.arrays import Array
from scenarios.errors import InputError

OPTION = "--unit-out"
COUNTS = ("count", "counts")
LOG = "log"
"""The log's own unit, as stated with --unit or --map."""


@dataclass(frozen=True)
class OutputUnit:
    """Unit of measurement and offset, and unit of the corrected field.

    h = matrix (m - offset),  m and offset in `measured`, h in `field`: the same unit, or nT for counts

    nT : of one unit of each axis
    """

    measured: str
    field: str
    nT: tuple[float, float, float]

    def offset(self, calibration: Calibration) -> Array:
        """Return the offset (3,) in the unit of measurement."""
        return np.asarray(calibration.offset_nT / np.array(self.nT))

    def matrix(self, calibration: Calibration) -> Array:
        """Return the matrix (3, 3) from the unit of measurement to the unit of the field."""
        to_nT = UNITS["mag"][self.field][0]
        return np.asarray(calibration.matrix * np.array(self.nT) / to_nT)

    @property
    def model(self) -> str:
        """Return the model in words."""
        of = "h and m" if self.field == self.measured else f"h in {self.field}, m"
        return f"h = matrix (m - offset), {of} in {self.measured}"


NANOTESLA = OutputUnit("nT", "nT", (1.0, 1.0, 1.0))


def output_unit(text: str, reading: Reading) -> OutputUnit:
    """Return the unit named by --unit-out: a unit of the field, `counts`, `counts=NT_A_COUNT`, or `log`.

    reading : where counts have their size, and the log its unit. Raises InputError for any other text, and where the
    reading does not state what is needed.
    """
    name, _, size = text.partition("=")
    if name in UNITS["mag"] and not size:
        return _physical(name)
    if name in COUNTS and size:
        return OutputUnit("counts", "nT", (_size(size),) * 3)
    if name in COUNTS:
        return _counts(reading)
    if name == LOG:
        return _of_log(reading)
    known = ", ".join((*UNITS["mag"], "counts", "counts=NT_A_COUNT", LOG))
    raise InputError(f"{text!r} is no unit", where=OPTION, do=f"choose among {known}")


def in_unit(calibrations: Mapping[str, Calibration], unit: OutputUnit) -> dict[str, Any]:
    """Return offsets and matrices by name in a unit, for JSON; null without an estimate."""
    fits = {
        name: {"offset": unit.offset(fit).tolist(), "matrix": unit.matrix(fit).tolist()} if fit.has_estimate else None
        for name, fit in calibrations.items()
    }
    return {"unit": unit.measured, "field_unit": unit.field, "nT": list(unit.nT), "calibrations": fits}


def _physical(name: str) -> OutputUnit:
    return OutputUnit(name, name, (UNITS["mag"][name][0],) * 3)


def _size(text: str) -> float:
    try:
        size = float(text)
    except ValueError:
        size = 0.0
    if not (np.isfinite(size) and size > 0):
        raise InputError(f"{text!r} is no size of a count in nT", where=OPTION, do="write counts=14.6")
    return size


def _mapped(reading: Reading) -> dict[str, tuple[str | None, float]]:
    """Return unit and size, |scale|, of the magnetometer's columns that maps name."""
    targets = mag_names()
    return {one.target: (one.unit, abs(one.scale)) for one in reading.column_maps if one.target in targets}


def _counts(reading: Reading) -> OutputUnit:
    """Return counts of the size that the maps state, or of unknown size, read as they are."""
    if reading.unit == COUNT:
        return OutputUnit("counts", "nT", (1.0, 1.0, 1.0))
    mapped = _mapped(reading)
    if len(mapped) != 3:
        do = "write counts=14.6, in nT, or map the three columns with scale=14.6"
        raise InputError("the size of a count is not stated", where=OPTION, do=do)
    sizes = [mapped[name][1] * UNITS["mag"][mapped[name][0] or "nT"][0] for name in mag_names()]
    return OutputUnit("counts", "nT", (sizes[0], sizes[1], sizes[2]))


def _of_log(reading: Reading) -> OutputUnit:
    """Return the unit that the reading states."""
    if reading.unit not in (None, COUNT):
        return _physical(str(reading.unit))
    mapped = set(_mapped(reading).values())
    if len(mapped) == 1:
        ((name, size),) = mapped
        if size == 1.0:
            return _physical(name or "nT")
    if reading.unit == COUNT or mapped:
        return _counts(reading)
    do = "name one, as --unit-out uT, or state the log's with --unit"
    raise InputError("the log's unit is not stated", where=OPTION, do=do)
