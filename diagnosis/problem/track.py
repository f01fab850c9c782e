"""Change of the Earth's field along a track, from latitude, longitude and altitude as recorded."""

from __future__ import annotations

import datetime
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from recordings import Recording
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.field import earth_field_along

NODES = 2000
"""Number of places at most at which the field model is evaluated; values between are interpolated."""
HIGHEST_M = 4e7
"""Altitude above any satellite with magnetic attitude control."""
ANY_DATE = datetime.date(2025, 1, 1)
"""Date for an undated field: differences between places 500 km apart change by up to about 5 nT a year."""


@dataclass(frozen=True)
class FieldTrack:
    """The middle place (latitude, longitude in degrees, altitude in m), and the field's change along the track.

    change_enu_nT (n, 3): of the vector; change_nT (n,): of its strength.
    """

    middle: tuple[float, float, float]
    change_enu_nT: Array
    change_nT: Array

    @classmethod
    def of(cls, recording: Recording, field: FieldSpec | None) -> FieldTrack | None:
        """The track of a recording with the model's field; rows without a place are interpolated.

        None without latitude and longitude. For a recorded altitude alone, latitude and longitude are the field's own,
        if given by place: the field of a balloon falls by some 20 nT in a kilometre. The middle is then the field's own
        place. Raises InputError for values that are no place.
        """
        stated = _stated_place(field)
        places = _places(recording, stated)
        known = np.flatnonzero(np.isfinite(places).all(axis=1))
        if not len(known):
            return None
        _check(places, known)
        nodes = known[np.unique(np.linspace(0, len(known) - 1, NODES).astype(int))]
        middle = places[known[len(known) // 2]] if stated is None or _has_place(recording) else stated
        date = None if field is None else field.date
        here, *at = earth_field_along(np.vstack([middle, places[nodes]]), date or ANY_DATE)
        strength = np.linalg.norm(at, axis=1) - np.linalg.norm(here)
        change = _between(recording.time_s, nodes, np.column_stack([np.array(at) - here, strength]))
        latitude, longitude, altitude = (float(value) for value in middle)
        return cls((latitude, longitude, altitude), change[:, :3], change[:, 3])

    def at(self, samples: NDArray[np.bool_]) -> FieldTrack:
        """The track at selected samples."""
        return FieldTrack(self.middle, self.change_enu_nT[samples], self.change_nT[samples])

    def field_enu_nT(self, given: FieldSpec) -> Array:
        """Vector (3,) of the field model at the middle place on a given date."""
        return np.asarray(earth_field_along(np.array([self.middle]), given.date or ANY_DATE)[0])


def _has_place(recording: Recording) -> bool:
    return LATITUDE in recording.channels and LONGITUDE in recording.channels


def _stated_place(field: FieldSpec | None) -> Array | None:
    """Latitude, longitude and altitude (3,) of a field given by place."""
    if field is None or field.latitude_deg is None or field.longitude_deg is None:
        return None
    return np.array([field.latitude_deg, field.longitude_deg, field.altitude_m])


def _places(recording: Recording, stated: Array | None) -> Array:
    """Latitude, longitude and altitude (n, 3), NaN where unknown; a stated place takes the recorded altitude."""
    there, n = recording.channels, len(recording)
    if _has_place(recording):
        return np.column_stack([there[LATITUDE], there[LONGITUDE], there.get(ALTITUDE, np.zeros(n))])
    if stated is None or ALTITUDE not in there:
        return np.full((n, 3), np.nan)
    return np.column_stack([np.full((n, 2), stated[:2]), there[ALTITUDE]])


def _between(time_s: Array, nodes: NDArray[np.intp], values: Array) -> Array:
    """Values (m, k) at nodes (m,) interpolated to all times (n,): a cubic without overshoot, constant outside."""
    at = time_s[nodes]
    if len(nodes) == 1:
        return np.repeat(values, len(time_s), axis=0)
    return np.asarray(PchipInterpolator(at, values)(np.clip(time_s, at[0], at[-1])))


def _check(places: Array, known: NDArray[np.intp]) -> None:
    """InputError for latitudes, longitudes or altitudes of known rows out of range."""
    low, high = np.array([-90.0, -180.0, -12e3]), np.array([90.0, 360.0, HIGHEST_M])
    for name, values, a, b in zip((LATITUDE, LONGITUDE, ALTITUDE), places[known].T, low, high, strict=True):
        wrong = (values < a) | (values > b)
        if wrong.any():
            what = f"{name} {values[wrong][0]:g} in row {known[np.argmax(wrong)]} is not between {a:g} and {b:g}"
            raise InputError(what, where="recording", do="leave rows without a place empty, or rename the column")
