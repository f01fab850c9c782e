"""Clocks and dates as text logs write them: `13:05:00.25`, `01.05.2024 13:05:00`, `5/1/2024 1:05:00 PM`, ISO 8601."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from recordings.readers.text.words import is_empty_mark
from scenarios.arrays import Array

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]

_CLOCK = (
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2})(?:[.,:](?P<fraction>\d{1,9}))?)?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}(?::?\d{2})?)?"
)
_DATES = (
    r"(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})",
    r"(?P<day>\d{1,2})\.(?P<month>\d{1,2})\.(?P<year>\d{4}|\d{2})",
    r"(?P<left>\d{1,2})[-/](?P<right>\d{1,2})[-/](?P<year>\d{4}|\d{2})",
    r"(?P<day>\d{1,2})[- ](?P<name>[A-Za-z]{3})[a-z]*[- ](?P<year>\d{4})",
)
_COMPACT = (
    r"(?P<year>\d{4})(?P<month>\d{2})(?P<day>\d{2})T(?P<hour>\d{2})(?P<minute>\d{2})(?P<second>\d{2})"
    r"(?:\.(?P<fraction>\d{1,9}))?(?P<half>)(?P<zone>Z|UTC|GMT|[+-]\d{2}(?::?\d{2})?)?"
)
_PATTERNS = (
    rf"^\s*{_CLOCK}\s*$",
    rf"^\s*{_COMPACT}\s*$",
    *(rf"^\s*{date}(?:[T ,_]\s*{_CLOCK})?\s*$" for date in _DATES),
)
"""Every form as a regular expression, the bare clock first."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_YEARS = (1678, 2261)
"""The years whose nanoseconds fit 64 bits."""
MOST_SAMPLED = 50
"""Cells by which the form of a column is recognised; the others are matched at once."""
DAY_S = 86_400
_NS = 10**9


@dataclass(frozen=True, eq=False)
class WrittenTimes:
    """The times in a column of text.

    Parameters
    ----------
    known : (n,) whether a cell holds a time.
    days : (n,) days since 1970, None for a bare clock.
    clock_ns : (n,) nanoseconds since midnight, in UTC where zoned; None for a bare date.
    zoned : whether the cells name a zone.
    note : on the order of day and month, where nothing tells.
    """

    known: Mask
    days: Whole | None
    clock_ns: Whole | None
    zoned: bool = False
    note: str = ""


def written_times(column: pa.Array) -> WrittenTimes | None:
    """Return the times in a column of text; None where the first cells are in no known form."""
    cells = [cell for cell in column[: 10 * MOST_SAMPLED].to_pylist() if cell and not is_empty_mark(cell)]
    sample = cells[:MOST_SAMPLED]
    for pattern in _PATTERNS:
        if sample and 2 * sum(bool(re.match(pattern, cell)) for cell in sample) > len(sample):
            return _times(_Parts(pc.extract_regex(column, pattern)))
    return None


class _Parts:
    """The groups of a pattern, matched in every cell of a column."""

    def __init__(self, matches: pa.StructArray) -> None:
        self.matches = matches
        self.names = [group.name for group in matches.type]

    def text(self, name: str) -> pa.Array:
        """Return a group as text (n,), empty where absent."""
        return pc.fill_null(pc.struct_field(self.matches, name), "")

    def number(self, name: str, digits: int = 0) -> Whole:
        """Return a group as a number (n,), 0 where absent; with `digits`, as a fraction of so many places."""
        padded = pc.utf8_rpad(self.text(name), max(digits, 1), "0") if digits else self.text(name)
        filled = pc.if_else(pc.equal(padded, ""), "0", padded)
        return np.asarray(_numpy(filled.cast(pa.int64())))

    def given(self, name: str) -> Mask:
        """Return where a group is not empty, (n,)."""
        return np.asarray(_numpy(pc.not_equal(self.text(name), "")))


def _times(parts: _Parts) -> WrittenTimes:
    known: Mask = _numpy(parts.matches.is_valid())
    zoned = parts.given("zone")
    clock_ns = _clock_ns(parts) if parts.given("hour").any() else None
    if "year" not in parts.names:
        return WrittenTimes(known, None, clock_ns, bool(zoned.any()))
    day, month, note = _day_and_month(parts, known)
    year = parts.number("year")
    year = np.where(year < 100, year + 2000, year)
    known &= (year >= _YEARS[0]) & (year <= _YEARS[1]) & (month >= 1) & (month <= 12) & (day >= 1) & (day <= 31)
    return WrittenTimes(known, _days(year, month, day), clock_ns, bool(zoned.any()), note)


def _clock_ns(parts: _Parts) -> Whole:
    """Return nanoseconds since midnight, in UTC where a zone is given: (n,)."""
    hour, half = parts.number("hour"), _numpy(pc.equal(pc.utf8_lower(parts.text("half")), "p"))
    hour = np.where(parts.given("half"), hour % 12 + 12 * half, hour)
    zones = parts.text("zone").dictionary_encode()
    ahead_s = np.array([_ahead_s(zone) for zone in zones.dictionary.to_pylist()], np.int64)
    seconds = 3600 * hour + 60 * parts.number("minute") + parts.number("second") - ahead_s[_numpy(zones.indices)]
    return np.asarray(seconds * _NS + parts.number("fraction", digits=9))


def _ahead_s(zone: str) -> int:
    """Return the seconds by which a zone's clock is ahead of UTC."""
    if zone[:1] not in ("+", "-"):
        return 0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return (3600 * int(digits[:2]) + 60 * int(digits[2:])) * (-1 if zone[0] == "-" else 1)


def _day_and_month(parts: _Parts, known: Mask) -> tuple[Whole, Whole, str]:
    """Return days and months (n,), and a note where nothing tells their order.

    A number above 12 is a day; else the order in which the dates do not go back; else the order of the country: month
    first with a clock of 12 hours, day first with one of 24.
    """
    if "name" in parts.names:
        names = pc.utf8_slice_codeunits(pc.utf8_lower(parts.text("name")), 0, 3)
        return parts.number("day"), _numpy(pc.index_in(names, pa.array(_MONTHS)).fill_null(-1)) + 1, ""
    if "left" not in parts.names:
        return parts.number("day"), parts.number("month"), ""
    left, right = parts.number("left"), parts.number("right")
    year = parts.number("year")
    fits = [(m.max(initial=0) <= 12, _rises(_days(year, m, d)[known])) for d, m in ((left, right), (right, left))]
    day_first = not parts.given("half").any() if fits[0] == fits[1] else fits[0] > fits[1]
    order = "day/month/year" if day_first else "month/day/year"
    note = f"dates were read as {order}; nothing in the file tells the order" if fits[0] == fits[1] else ""
    return (left, right, note) if day_first else (right, left, note)


def _rises(days: Whole) -> bool:
    return bool(np.all(np.diff(days) >= 0))


def _days(year: Whole, month: Whole, day: Whole) -> Whole:
    """Return days since 1970, (n,)."""
    months = ((year - 1970) * 12 + month - 1).astype("datetime64[M]")
    return np.asarray(months.astype("datetime64[D]").astype(np.int64) + day - 1)


def unwrapped_s(clock_s: Array) -> tuple[Array, int]:
    """Return seconds since midnight (n,), NaN where unknown, plus a day after each midnight; and the midnights.

    Midnight is a step back by more than half a day.
    """
    known = np.flatnonzero(np.isfinite(clock_s))
    nights = np.cumsum(np.diff(clock_s[known], prepend=clock_s[known][:1]) < -DAY_S / 2)
    unwrapped = clock_s.copy()
    unwrapped[known] += DAY_S * nights
    return unwrapped, int(nights[-1]) if len(nights) else 0


def timestamps(days: Whole, clock_ns: Whole, known: Mask, zoned: bool) -> pa.Array:
    """Return days since 1970 and nanoseconds since midnight as timestamps, null where not known."""
    ticks = pa.array(np.where(known, days, 0) * (DAY_S * _NS) + clock_ns, pa.int64(), mask=~known)
    return ticks.cast(pa.timestamp("ns", "UTC" if zoned else None))


def _numpy(values: pa.Array) -> Any:
    return np.asarray(values.to_numpy(zero_copy_only=False))
