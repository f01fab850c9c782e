"""Where and when a PX4 log was made, by its GPS."""

from __future__ import annotations

import datetime
from dataclasses import dataclass

import numpy as np

from recordings.readers.px4.contents import ULog, UlogTopic
from scenarios.arrays import Array

FIX_3D = 3
"""fix_type from which latitude, longitude and altitude are known."""
EARTH_M = 6_371_000.0
YEARS = (2005, 2100)
"""Dates outside these years are clocks that were not set."""


@dataclass(frozen=True, eq=False)
class GpsFixes:
    """Valid fixes: times_s (n,), place (n, 3): latitude and longitude in degrees, altitude above the ellipsoid in m."""

    times_s: Array
    place: Array


def fixes(log: ULog) -> GpsFixes | None:
    """Return the fixes of the GPS, or of the position estimate; None where the log holds none."""
    for topic in (*log.instances("vehicle_gps_position"), *log.instances("sensor_gps")):
        place = _place(topic)
        known = np.isfinite(place).all(axis=1) & np.any(place != 0, axis=1)
        known &= topic.column("fix_type") >= FIX_3D if "fix_type" in topic else True
        if known.any():
            return GpsFixes(topic.times_s()[known], place[known])
    estimate = log.first("vehicle_global_position")
    if estimate is None or not {"lat", "lon", "alt"} <= set(estimate.names):
        return None
    return GpsFixes(estimate.times_s(), estimate.vectors("lat", "lon", "alt"))


def place_and_date(log: ULog) -> tuple[tuple[float, ...] | None, datetime.date | None]:
    """Return the median of the fixes (degrees, degrees, m), and the date (UTC) in the middle of the log."""
    found = fixes(log)
    place = tuple(float(value) for value in np.median(found.place, axis=0)) if found else None
    whole = place is not None and abs(place[0]) <= 90 and abs(place[1]) <= 180 and abs(place[2]) < 1e5
    return place if whole else None, _date(log)


def local_enu(place: Array) -> Array:
    """Return positions (n, 3) east, north, up in m relative to the first place, of a sphere."""
    latitude, longitude = np.radians(place[:, 0]), np.radians(place[:, 1])
    east = (longitude - longitude[0]) * np.cos(latitude[0]) * EARTH_M
    return np.column_stack([east, (latitude - latitude[0]) * EARTH_M, place[:, 2] - place[0, 2]])


def _place(topic: UlogTopic) -> Array:
    """Return latitude, longitude and altitude (n, 3): in newer logs degrees and m, in older 1e-7 degrees and mm."""
    metres = next((name for name in ("altitude_ellipsoid_m", "altitude_msl_m") if name in topic), "")
    if metres and {"latitude_deg", "longitude_deg"} <= set(topic.names):
        return topic.vectors("latitude_deg", "longitude_deg", metres)
    if not {"lat", "lon", "alt"} <= set(topic.names):
        return np.full((len(topic), 3), np.nan)
    height = "alt_ellipsoid" if "alt_ellipsoid" in topic else "alt"
    return topic.vectors("lat", "lon", height) * (1e-7, 1e-7, 1e-3)


def _date(log: ULog) -> datetime.date | None:
    """Return the date by the GPS, else by a log's own clock that counts from 1970, as a simulation's."""
    for topic in (*log.instances("vehicle_gps_position"), *log.instances("sensor_gps"), *log.topics.values()):
        name = "time_utc_usec" if "time_utc_usec" in topic else "timestamp"
        since_1970_s = topic.times_s(name)
        set_clock = since_1970_s[since_1970_s > 0]
        if len(set_clock) and (date := _day(float(np.median(set_clock)))):
            return date
    return None


def start_of(log: ULog) -> float | None:
    """Return seconds since 1970 (UTC) at the log's time 0, by the satellites' clock; None without."""
    for topic in (*log.instances("vehicle_gps_position"), *log.instances("sensor_gps")):
        if "time_utc_usec" in topic:
            utc_s = topic.times_s("time_utc_usec")
            start_s = float(np.median((utc_s - topic.times_s())[utc_s > 0])) if (utc_s > 0).any() else 0.0
            if _day(start_s) is not None:
                return start_s
    return None


def _day(since_1970_s: float) -> datetime.date | None:
    earliest, latest = (datetime.datetime(year, 1, 1, tzinfo=datetime.UTC).timestamp() for year in YEARS)
    if not earliest < since_1970_s < latest:
        return None
    return datetime.datetime.fromtimestamp(since_1970_s, datetime.UTC).date()
