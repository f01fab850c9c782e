"""The calendar date of the clocks that vehicles' logs tell: satellites' weeks, and microseconds since 1970."""

from __future__ import annotations

import datetime

GPS_START = datetime.datetime(1980, 1, 6)
"""Satellites count weeks and seconds from here, without leap seconds."""
WEEK_S = 604_800.0
LEAP_SECONDS = {
    datetime.date(2017, 1, 1): 18,
    datetime.date(2015, 7, 1): 17,
    datetime.date(2012, 7, 1): 16,
    datetime.date(2009, 1, 1): 15,
    datetime.date(2006, 1, 1): 14,
}
"""Seconds by which the satellites' clock is ahead of UTC, from each day on [IERS Bulletin C]."""
EARLIEST, LATEST = datetime.date(1990, 1, 1), datetime.date(2100, 1, 1)
"""Dates outside belong to a clock that was never set."""


def gps_utc_s(week: float, second: float) -> float | None:
    """Return seconds since 1970 (UTC) of a week and a second of the satellites' clock; None for one not set."""
    if not 0 <= second <= WEEK_S or not 0 < week < 10_000:
        return None
    when = GPS_START + datetime.timedelta(weeks=week, seconds=second)
    leap = next((seconds for day, seconds in LEAP_SECONDS.items() if when.date() >= day), 13)
    utc = when - datetime.timedelta(seconds=leap)
    return None if _set(utc.date()) is None else (utc - datetime.datetime(1970, 1, 1)).total_seconds()


def unix_date(second: float) -> datetime.date | None:
    """Return the UTC date of seconds since 1970; None for a clock that was not set."""
    if not 0 <= second < 4e9:
        return None
    return _set((datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=second)).date())


def _set(date: datetime.date) -> datetime.date | None:
    return date if EARLIEST <= date < LATEST else None
