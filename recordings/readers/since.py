"""Units of time as netCDF writes them: `seconds since 1970-01-01T00:00:00Z`."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array

_SINCE = re.compile(
    r"\s*(?P<unit>[a-z]+)\s+since\s+(?P<date>\d{4}-\d{1,2}-\d{1,2})"
    r"(?:[T ]\s*(?P<clock>\d{1,2}:\d{1,2}(?::\d{1,2}(?:\.\d*)?)?))?\s*(?:Z|UTC|\+?0{1,2}:?0{0,2})?\s*",
    re.IGNORECASE,
)
_SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), 1e-9),
    **dict.fromkeys(("min", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hour", "hours"), 3600.0),
    **dict.fromkeys(("d", "day", "days"), 86_400.0),
}


@dataclass(frozen=True)
class Since:
    """A unit in s, and the start in s since 1970 (UTC)."""

    unit_s: float
    start_s: float

    def seconds(self, values: Array) -> Array:
        """Return values in the unit as seconds since 1970."""
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is missing
            return np.asarray(self.start_s + self.unit_s * np.asarray(values, np.float64))


def since_of(text: str) -> Since | None:
    """Return the unit and start in a text; None for another unit, or a day that no calendar has."""
    found = _SINCE.fullmatch(text)
    unit_s = _SECONDS.get(found["unit"].lower()) if found else None
    if found is None or unit_s is None:
        return None
    year, month, day = (int(part) for part in found["date"].split("-"))
    try:
        start = np.datetime64(f"{year:04}-{month:02}-{day:02}", "s")
    except ValueError:
        return None
    clock = [float(part) for part in (found["clock"] or "0").split(":")]
    within_s = sum(part * factor for part, factor in zip(clock, (3600.0, 60.0, 1.0), strict=False))
    return Since(unit_s, float(start.astype(np.int64)) + within_s)
