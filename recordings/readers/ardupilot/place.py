"""Where and when a DataFlash log was made, from its satellite receiver."""

from __future__ import annotations

import datetime

import numpy as np

from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from recordings.readers.ardupilot.messages import Dataflash, Messages
from recordings.readers.utc import gps_utc_s, unix_date
from recordings.streams import Stream

THREE_D_FIX = 3
"""GPS.Status from which a fix has latitude, longitude and altitude."""
PLACE = ("Lat", "Lng", "Alt")
WEEK, MILLISECOND = ("GWk", "Week"), ("GMS", "TimeMS")
"""The week, and the time in it in ms, by their newer and their older names."""


def fixes_of(log: Dataflash) -> Messages | None:
    """Return the fixes of the first receiver that has any, None where none has."""
    for _, rows in sorted(log.instances("GPS").items()):
        if "Status" in rows and all(name in rows for name in PLACE):
            fixed = rows.where((rows.numbers("Status") >= THREE_D_FIX) & rows.vector("Lat", "Lng").any(axis=1))
            if len(fixed):
                return fixed
    return None


def place_of(fixes: Messages) -> tuple[float, ...] | None:
    """Return the median of latitude and longitude, deg, and altitude, m; None where that is no place on Earth."""
    latitude, longitude, altitude = (float(x) for x in np.median(fixes.vector(*PLACE), axis=0))
    return (latitude, longitude, altitude) if abs(latitude) <= 90 and abs(longitude) <= 180 else None


def date_of(fixes: Messages) -> datetime.date | None:
    """Return the day (UTC) of the middle fix; None where the log has no time of satellites."""
    since_1970_s = _middle_utc_s(fixes)
    return None if since_1970_s is None else unix_date(since_1970_s)


def start_of(log: Dataflash, fixes: Messages) -> float | None:
    """Return seconds since 1970 (UTC) at the log's time 0, by the middle fix."""
    since_1970_s = _middle_utc_s(fixes)
    return None if since_1970_s is None else since_1970_s - float(log.times_s(fixes)[len(fixes) // 2])


def _middle_utc_s(fixes: Messages) -> float | None:
    week, millisecond = (next((n for n in names if n in fixes), None) for names in (WEEK, MILLISECOND))
    if week is None or millisecond is None:
        return None
    middle = len(fixes) // 2
    return gps_utc_s(float(fixes.numbers(week)[middle]), float(fixes.numbers(millisecond)[middle]) / 1000)


def place_stream(log: Dataflash) -> dict[str, Stream]:
    """Return latitude and longitude in degrees and the altitude in m at the fixes."""
    fixes = fixes_of(log)
    if fixes is None:
        return {}
    columns = dict(zip((LATITUDE, LONGITUDE, ALTITUDE), fixes.vector(*PLACE).T, strict=True))
    return {"fixes": Stream(log.times_s(fixes), columns)}
