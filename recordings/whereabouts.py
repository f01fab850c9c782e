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
from recordings.interpretation import SECONDS_1970
from recordings.likely_units import stamp_unit
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
    """Return the UTC date in the middle of the first column that tells one; None without any.

    Such are dates, dates with times, stamps since 1970 whose name says UTC, whole numbers YYYYMMDD named date,
    and three columns year, month, day.
    """
    whole = {name: table.column(name) for name in table.column_names if _is_number(table.column(name).type)}
    found = (
        *(_middle_date(column) for column in table.columns if pa.types.is_temporal(column.type)),
        *(_counted_date(name, column) for name, column in whole.items()),
        _date_of_parts(whole),
    )
    return next((date for date in found if date is not None), None)


def _is_number(kind: pa.DataType) -> bool:
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))


def _middle_date(column: pa.ChunkedArray) -> datetime.date | None:
    known = column.drop_null() if pa.types.is_date(column.type) or pa.types.is_timestamp(column.type) else ()
    if not len(known):
        return None
    return unix_date(float(pc.cast(known[len(known) // 2].cast(pa.timestamp("s"), safe=False), pa.int64()).as_py()))


def _middle_value(column: pa.ChunkedArray) -> float:
    """Return the middle value that is finite and not zero, 0 without any."""
    values = column.cast(pa.float64(), safe=False).to_numpy()
    known = values[np.isfinite(values) & (values != 0)]
    return float(known[len(known) // 2]) if len(known) else 0.0


def _counted_date(name: str, column: pa.ChunkedArray) -> datetime.date | None:
    """Return the date of stamps since 1970, or of YYYYMMDD."""
    words = set(ColumnName(name).words)
    if words & {"utc", "unix", "epoch", "unixtime"}:
        value = np.array([_middle_value(column)])
        unit = stamp_unit(value)
        seconds = float(value[0]) * (UNITS["time"][unit][0] if unit else 1.0)
        return unix_date(seconds) if seconds > SECONDS_1970[0] else None
    return _calendar(*_parts_of(_middle_value(column))) if "date" in words else None


def _parts_of(value: float) -> tuple[float, float, float]:
    """Return year, month and day of a number YYYYMMDD."""
    return value // 10_000, value // 100 % 100, value % 100


def _date_of_parts(whole: Mapping[str, pa.ChunkedArray]) -> datetime.date | None:
    last = {ColumnName(name).words[-1]: name for name in reversed(list(whole)) if ColumnName(name).words}
    names = [last.get(word) for word in ("year", "month", "day")]
    return _calendar(*(_middle_value(whole[name]) if name else 0.0 for name in names))


def _calendar(year: float, month: float, day: float) -> datetime.date | None:
    """Return a date; None for a day that no calendar has, or a clock that was not set."""
    if not (1990 <= year < 2100 and 1 <= month <= 12 and 1 <= day <= 31):
        return None
    try:
        return datetime.date(int(year), int(month), int(day))
    except ValueError:
        return None


def _by_words(named: Named, of: tuple[str, ...]) -> Iterator[tuple[frozenset[str], str]]:
    """Yield the other words, and the name, of each column of numbers that has one of some words."""
    for name, values in named.items():
        words = set(ColumnName(name).words)
        if words & set(of) and not words & ELSEWHERE and values.dtype.kind == "f":
            yield frozenset(words - {*of, *UNITS["position"], "deg", "degrees", "rad", "wgs", "meters", "metres"}), name


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
