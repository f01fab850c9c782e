"""Place and date of a log from its own columns: latitude, longitude, altitude by name; stamps since 1970, dates."""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from recordings.column_words import ColumnName
from recordings.readers.navigation import median_place
from recordings.readers.utc import unix_date
from recordings.units import UNITS
from scenarios.arrays import Array

Named = Mapping[str, NDArray[Any]]
NORTH, EAST, ABOVE = ("latitude", "lat"), ("longitude", "lon", "long", "lng"), ("altitude", "alt")
"""Words of a column of latitude, of longitude, and of altitude."""
ELSEWHERE = frozenset(
    (
        "home",
        "target",
        "goal",
        "std",
        "sigma",
        "accuracy",
        "acc",
        "error",
        "err",
        "var",
        "origin",
        "ref",
        "vel",
        "speed",
    )
)
"""Words of columns that tell another place than the vehicle's, or how well its own is known."""
WHOLE, WHOLE_MM = 1e-7, 1e-3
"""Degrees and metres of a count, where receivers write whole numbers."""
MOST_ALTITUDE_M = 100_000.0


def place_in(named: Named) -> tuple[float, ...] | None:
    """Return the median latitude, longitude (degrees) and altitude (m) in columns (n,); None without both angles.

    The columns share all words but those of NORTH, EAST and ABOVE. Whole numbers beyond 360 are 1e-7 degrees, with
    altitudes in mm; angles whose name says rad are radians. An altitude that is not there is 0.
    """
    east, above = dict(_by_words(named, EAST)), dict(_by_words(named, ABOVE))
    for words, name in _by_words(named, NORTH):
        if words in east:
            latitude, longitude = (_degrees(one, named[one]) for one in (name, east[words]))
            known = np.isfinite(latitude) & np.isfinite(longitude)
            whole = _is_whole(named[name])
            height_m = _altitude_m(above.get(words), named, known, whole) if known.any() else 0.0
            found = median_place(latitude[known], longitude[known], height_m)
            if found is not None:
                return found
    return None


def date_at(start_s: float | None, time_s: Array) -> datetime.date | None:
    """Return the UTC date of the middle of a log that began at start_s since 1970; None for a clock not set."""
    finite = time_s[np.isfinite(time_s)]
    return None if start_s is None or not len(finite) else unix_date(start_s + float(np.median(finite)))


def date_in(table: pa.Table) -> datetime.date | None:
    """Return the UTC date in the middle of the first column of dates, or of dates with times; None without any."""
    kinds = (pa.types.is_date, pa.types.is_timestamp)
    for column in table.columns:
        known = column.drop_null() if any(is_kind(column.type) for is_kind in kinds) else ()
        if len(known):
            seconds = pc.cast(known[len(known) // 2].cast(pa.timestamp("s"), safe=False), pa.int64()).as_py()
            found = unix_date(float(seconds))
            if found is not None:
                return found
    return None


def _by_words(named: Named, of: tuple[str, ...]) -> Iterator[tuple[frozenset[str], str]]:
    """Yield the other words, and the name, of each column of numbers that has one of some words."""
    for name, values in named.items():
        words = set(ColumnName(name).words)
        if words & set(of) and not words & ELSEWHERE and values.dtype.kind == "f":
            yield frozenset(words - {*of, *UNITS["position"], "deg", "degrees", "rad", "wgs"}), name


def _is_whole(values: Array) -> bool:
    """Return whether values are whole numbers beyond any angle in degrees."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and np.abs(finite).max() > 360 and (finite == np.round(finite)).all())


def _degrees(name: str, values: Array) -> Array:
    """Return angles in degrees: of counts of 1e-7, of radians where the name says so."""
    found = WHOLE * values if _is_whole(values) else values
    angle = ColumnName(name)
    return np.degrees(found) if "rad" in (*angle.words, angle.bracketed) else found


def _altitude_m(name: str | None, named: Named, known: NDArray[np.bool_], whole: bool) -> float:
    """Return the median altitude at fixes in m, 0 where unknown; in mm where the angles are whole numbers."""
    if name is None:
        return 0.0
    values = named[name][known & np.isfinite(named[name])]
    unit = ColumnName(name).bracketed or next(iter(ColumnName(name).words[-1:]), "")
    factor = UNITS["position"][unit][0] if unit in UNITS["position"] else WHOLE_MM if whole else 1.0
    height_m = float(np.median(values)) * factor if len(values) else 0.0
    return height_m if abs(height_m) < MOST_ALTITUDE_M else 0.0
