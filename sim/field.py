"""The Earth's undisturbed field at a place and date."""

from __future__ import annotations

import datetime
from functools import lru_cache

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.portable_arithmetic import extended

FIRST_DATE, LAST_DATE = datetime.date(1900, 1, 1), datetime.date(2030, 1, 1)
"""First and last date of IGRF-14; the last five years are a forecast."""

MOST_LATITUDE_DEG = 90.0 - 1e-6
"""A decimetre from the pole: the model divides by the distance from the axis."""


def earth_field_enu_nT(field: FieldSpec) -> Array:
    """Field vector (3,) in nT, east, north, up: as given, or IGRF-14 at geodetic latitude, longitude, altitude.

    The altitude counts from the WGS-84 ellipsoid. Raises InputError for a date outside the model.
    Source: Alken et al. 2021, Earth Planets Space 73:49, with IAGA's coefficients of 2024 (ppigrf).
    """
    if field.enu_nT is not None:
        return np.array(field.enu_nT)
    assert field.date is not None
    assert field.latitude_deg is not None  # FieldSpec: place and date go together
    _check_date(field.date)
    return np.array(_modelled(field.latitude_deg, field.longitude_deg, field.altitude_m, field.date))


def earth_field_along(places: Array, date: datetime.date) -> Array:
    """IGRF-14 field vectors (n, 3) in nT, east, north, up, at places (n, 3): latitude, longitude in degrees, metres.

    The altitude counts from the WGS-84 ellipsoid. Raises InputError for a date outside the model.
    Source: as of `earth_field_enu_nT`.
    """
    _check_date(date)
    import ppigrf

    latitude = np.clip(places[:, 0], -MOST_LATITUDE_DEG, MOST_LATITUDE_DEG)
    midnight = datetime.datetime.combine(date, datetime.time())
    return np.column_stack(
        [part.ravel() for part in ppigrf.igrf(places[:, 1], latitude, places[:, 2] / 1000.0, midnight)]
    )


def _check_date(date: datetime.date) -> None:
    if not FIRST_DATE <= date <= LAST_DATE:
        covered = f"{FIRST_DATE} to {LAST_DATE}"
        raise InputError(f"IGRF-14 covers {covered}, found {date}", where="field.date", do="or give field.enu_nT")


@lru_cache(maxsize=64)
def _modelled(latitude_deg: float, longitude_deg: float, altitude_m: float, date: datetime.date) -> tuple[float, ...]:
    """IGRF-14, cached: an evaluation takes 30 ms, and every run of a scenario has the same place."""
    # Imported here: it loads pandas, which scenarios with a given vector need not wait for.
    import ppigrf

    midnight = datetime.datetime.combine(date, datetime.time())
    place = (longitude_deg, np.clip(latitude_deg, -MOST_LATITUDE_DEG, MOST_LATITUDE_DEG), altitude_m / 1000.0)
    return tuple(float(part.item()) for part in ppigrf.igrf(*map(extended, place), midnight))
