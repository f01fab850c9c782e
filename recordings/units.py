"""The units of measured logs, and the `--map` option that renames and converts columns."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE, REFERENCE, SCALAR
from recordings.columns import SIGNALS, group_of
from scenarios.arrays import Array
from scenarios.errors import InputError

STANDARD_GRAVITY_M_S2 = 9.80665
_SYNTAX = "write --map mag_x_nT=bx,unit=uT (also scale=-1 to turn an axis or to apply a factor)"
_DEG = math.pi / 180

UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "time": {"s": (1.0, 0.0), "ms": (1e-3, 0.0), "us": (1e-6, 0.0), "ns": (1e-9, 0.0), "min": (60.0, 0.0)},
    "mag": {
        "nT": (1.0, 0.0),
        "pT": (1e-3, 0.0),
        "uT": (1e3, 0.0),
        "mT": (1e6, 0.0),
        "T": (1e9, 0.0),
        "G": (1e5, 0.0),
        "gauss": (1e5, 0.0),
        "mG": (1e2, 0.0),
    },
    "gyro": {
        "rad/s": (1.0, 0.0),
        "rad_s": (1.0, 0.0),
        "mrad/s": (1e-3, 0.0),
        "deg/s": (_DEG, 0.0),
        "deg_s": (_DEG, 0.0),
        "dps": (_DEG, 0.0),
    },
    "accel": {
        "m/s^2": (1.0, 0.0),
        "m_s2": (1.0, 0.0),
        "m/s2": (1.0, 0.0),
        "g": (STANDARD_GRAVITY_M_S2, 0.0),
        "mg": (STANDARD_GRAVITY_M_S2 / 1e3, 0.0),
    },
    "position": {"m": (1.0, 0.0), "cm": (1e-2, 0.0), "mm": (1e-3, 0.0), "km": (1e3, 0.0), "ft": (0.3048, 0.0)},
    "temperature": {"degC": (1.0, 0.0), "K": (1.0, -273.15), "degF": (5 / 9, -160 / 9)},
    "current": {"A": (1.0, 0.0), "mA": (1e-3, 0.0)},
}
"""Units by column group: (factor, offset), with value in the column's own unit = factor * value + offset."""

CHANNELS = {**dict.fromkeys((SCALAR, *REFERENCE), "mag"), ALTITUDE: "position", LATITUDE: "", LONGITUDE: ""}
"""Channels with a defined meaning, and the column group whose units each takes."""

TARGETS = tuple(name for s in SIGNALS for name in s.names(None if s.group == "mag" else 1)) + tuple(CHANNELS)
"""Examples of a map's targets; sensors of an array and further motors are numbered."""


@dataclass(frozen=True)
class ColumnMap:
    """A `--map` option: target = scale * (factor * source + offset); `unit` gives factor and offset."""

    target: str
    source: str
    unit: str | None = None
    scale: float = 1.0

    def convert(self, values: Array) -> Array:
        """Return values (n,) of the source in the unit of the target."""
        factor, offset = UNITS[_group(self.target)][self.unit] if self.unit else (1.0, 0.0)
        if (factor, offset, self.scale) == (1.0, 0.0, 1.0):
            return values
        with np.errstate(over="ignore"):  # an overflow is infinite, and refused later
            return np.asarray(self.scale * (factor * values + offset))


def parse_maps(texts: Sequence[str]) -> tuple[ColumnMap, ...]:
    """Parse `TARGET=SOURCE[,unit=U][,scale=F]` texts.

    Raises InputError for wrong syntax, a target that is no column of a recording, an unknown or unsuitable unit, and a
    target given twice.
    """
    maps = tuple(_parse(text) for text in texts)
    targets = [entry.target for entry in maps]
    for i, target in enumerate(targets):
        if target in targets[:i]:
            raise InputError("is given twice", where=f"--map {target}", do="keep one of them")
    return maps


def likely_unit(norm: float) -> str | None:
    """Return the unit in which a field strength `norm` would be near the Earth's: 15,000 to 150,000 nT."""
    found = (unit for unit, (factor, _) in UNITS["mag"].items() if 15_000 <= norm * factor < 150_000)
    return next(found, None)


def _group(target: str) -> str:
    return CHANNELS.get(target, group_of(target))


def _parse(text: str) -> ColumnMap:
    where = f"--map {text}"
    head, *options = text.split(",")
    target, equals, source = (part.strip() for part in head.partition("="))
    if not (target and equals and source):
        raise InputError("is not of the form TARGET=SOURCE", where=where, do=_SYNTAX)
    if _group(target) in ("channel", "truth", "effect"):
        spelt = {name.lower(): name for name in TARGETS}
        near = [spelt[word] for word in difflib.get_close_matches(target.lower(), spelt)] or TARGETS
        raise InputError(f"a recording has no column {target!r}", where=where, do=f"use {', '.join(near)}")
    return _with_options(ColumnMap(target, source), options, where)


def _with_options(plain: ColumnMap, options: Sequence[str], where: str) -> ColumnMap:
    given: dict[str, str] = {}
    for option in options:
        key, equals, value = (part.strip() for part in option.partition("="))
        if key not in ("unit", "scale") or not (equals and value) or key in given:
            raise InputError(f"cannot use {option.strip()!r}", where=where, do=_SYNTAX)
        given[key] = value
    unit = given.get("unit")
    if unit is not None:
        _check_unit(plain.target, unit, where)
    return ColumnMap(plain.target, plain.source, unit, _scale(given.get("scale", "1"), where))


def _check_unit(target: str, unit: str, where: str) -> None:
    allowed = UNITS.get(_group(target), {})
    if unit in allowed:
        return
    do = f"{target} takes {', '.join(allowed)}" if allowed else f"{target} takes no unit"
    kinds = [kind for kind, units in UNITS.items() if unit in units]
    what = f"unit {unit} is for {' and '.join(kinds)}" if kinds else f"unit {unit} is not known"
    raise InputError(what, where=where, do=do)


def _scale(text: str, where: str) -> float:
    try:
        scale = float(text)
    except ValueError:
        scale = math.nan
    if not math.isfinite(scale) or scale == 0:
        raise InputError(f"scale {text!r} is not a number other than zero", where=where, do=_SYNTAX)
    return scale
