"""Angles and positions of a log's navigation as a recording's: quaternions of Euler angles, metres east and north."""

from __future__ import annotations

import numpy as np

from recordings.body_frame import enu_from_ned
from scenarios.arrays import Array

EARTH_RADIUS_M = 6_371_008.8
"""The mean radius of the Earth [GRS 80]: distances east and north within 0.6 % anywhere."""


def enu_of_angles(roll_rad: Array, pitch_rad: Array, yaw_rad: Array) -> Array:
    """Return the attitude (n, 4), w x y z, FLU to ENU, of aerospace angles (n,): yaw, then pitch, then roll.

    Roll is positive with the right side down, pitch with the nose up, yaw clockwise from north; FRD to NED
    q = (cos y/2 + k sin y/2)(cos p/2 + j sin p/2)(cos r/2 + i sin r/2).
    """
    half = [np.asarray(angle, np.float64) / 2 for angle in (roll_rad, pitch_rad, yaw_rad)]
    (cr, cp, cy), (sr, sp, sy) = [np.cos(angle) for angle in half], [np.sin(angle) for angle in half]
    parts = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    return enu_from_ned(np.column_stack(parts))


def east_north_m(latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Array]:
    """Return metres east and north (n,) of the first finite position: R cos(lat) dlon, R dlat."""
    known = np.flatnonzero(np.isfinite(latitude_deg) & np.isfinite(longitude_deg))
    first = known[0] if len(known) else 0
    turn = (np.radians(longitude_deg - longitude_deg[first]) + np.pi) % (2 * np.pi) - np.pi
    north_m = EARTH_RADIUS_M * np.radians(latitude_deg - latitude_deg[first])
    return EARTH_RADIUS_M * np.cos(np.radians(latitude_deg[first])) * turn, north_m


def median_place(latitude_deg: Array, longitude_deg: Array, altitude_m: float = 0.0) -> tuple[float, ...] | None:
    """Return the median of the positions on the Earth, and the altitude; None without any.

    (0, 0) counts as none: receivers write it without a fix.
    """
    inside = (
        (np.abs(latitude_deg) <= 90) & (np.abs(longitude_deg) <= 360) & ((latitude_deg != 0) | (longitude_deg != 0))
    )
    if not inside.any():
        return None
    return float(np.median(latitude_deg[inside])), float(np.median(longitude_deg[inside])), altitude_m
