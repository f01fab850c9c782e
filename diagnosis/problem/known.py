"""What is known beside a recording: the field along its track, the level, the model's effects, and corrections."""

from __future__ import annotations

import datetime
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from diagnosis.policy import STANDARD, Policy
from recordings import Recording
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.effects.base import Effect
from sim.field import earth_field_along

NODES = 2000
"""Number of places at most at which the field model is evaluated; values between are interpolated."""
HIGHEST_M = 4e7
"""Altitude above any satellite with magnetic attitude control."""
ANY_DATE = datetime.date(2025, 1, 1)
"""Date for an undated field: differences between places 500 km apart change by up to about 5 nT a year."""


@dataclass(frozen=True)
class FieldTrack:
    """The field model (3,) east, north, up in nT at the middle place, and its change (n, 3) along the track."""

    field_enu_nT: Array
    change_enu_nT: Array

    @classmethod
    def of(cls, recording: Recording, field: FieldSpec | None) -> FieldTrack | None:
        """The track of a recording with the model's field; rows without a place are interpolated.

        None without latitude and longitude. For a recorded altitude alone, latitude and longitude are the field's own,
        if given by place, which is then the middle: the field of a balloon falls by some 20 nT in a kilometre. Raises
        InputError for values that are no place.
        """
        places, middle = _places(recording, field)
        known = np.flatnonzero(np.isfinite(places).all(axis=1))
        if not len(known):
            return None
        _check(places, known)
        middle = places[known[len(known) // 2]] if middle is None else middle
        nodes = known[np.unique(np.linspace(0, len(known) - 1, NODES).astype(int))]
        date = ANY_DATE if field is None or field.date is None else field.date
        here, *there = earth_field_along(np.vstack([middle, places[nodes]]), date)
        changes, at_s = np.array(there) - here, recording.time_s[nodes]
        if len(nodes) == 1:
            return cls(here, np.repeat(changes, len(recording), axis=0))
        # a cubic without overshoot, constant outside
        return cls(here, PchipInterpolator(at_s, changes)(np.clip(recording.time_s, at_s[0], at_s[-1])))

    @property
    def change_nT(self) -> Array:
        """Change (n,) of the field's strength along the track."""
        here = self.field_enu_nT
        return np.asarray(np.linalg.norm(here + self.change_enu_nT, axis=1) - np.linalg.norm(here))


def _places(recording: Recording, field: FieldSpec | None) -> tuple[Array, Array | None]:
    """Latitude, longitude and altitude (n, 3), NaN where unknown; the field's own place (3,) where used."""
    there, n = recording.channels, len(recording)
    if LATITUDE in there and LONGITUDE in there:
        return np.column_stack([there[LATITUDE], there[LONGITUDE], there.get(ALTITUDE, np.zeros(n))]), None
    if field is None or field.latitude_deg is None or field.longitude_deg is None or ALTITUDE not in there:
        return np.full((n, 3), np.nan), None
    own = np.array([field.latitude_deg, field.longitude_deg, field.altitude_m])
    return np.column_stack([np.full((n, 2), own[:2]), there[ALTITUDE]]), own


def _check(places: Array, known: NDArray[np.intp]) -> None:
    """InputError for latitudes, longitudes or altitudes of known rows out of range."""
    low, high = np.array([-90.0, -180.0, -12e3]), np.array([90.0, 360.0, HIGHEST_M])
    for name, values, a, b in zip((LATITUDE, LONGITUDE, ALTITUDE), places[known].T, low, high, strict=True):
        wrong = (values < a) | (values > b)
        if wrong.any():
            what = f"{name} {values[wrong][0]:g} in row {known[np.argmax(wrong)]} is not between {a:g} and {b:g}"
            raise InputError(what, where="recording", do="leave rows without a place empty, or rename the column")


@dataclass(frozen=True, eq=False)
class Level:
    """Unit vectors down (n, 3) in the body frame, and the dip (n,) in rad of the given field."""

    down: Array
    dip_rad: Array

    @classmethod
    def of(cls, R_wb: Array, field_enu_nT: Array, policy: Policy, track: FieldTrack | None = None) -> Level | None:
        """Down vectors from attitudes (n, 3, 3), independent of the heading; None for a nearly vertical field.

        The dip changes along a track.
        """
        if np.hypot(*field_enu_nT[:2]) <= policy.trace * np.linalg.norm(field_enu_nT):
            return None
        east, north, up = (np.zeros((len(R_wb), 3)) + field_enu_nT + (0.0 if track is None else track.change_enu_nT)).T
        return cls(-R_wb[:, 2], np.arctan2(-up, np.hypot(east, north)))


@dataclass(frozen=True)
class ReferenceCorrection:
    """An error of the given reference and its correction, as a sentence and as advice with figures.

    field_enu_nT (3,): the field east, north, up that holds after the correction; None if the given field still holds.
    """

    words: str
    figures: str
    field_enu_nT: Array | None = None


@dataclass(frozen=True)
class Known:
    """What is known beside a recording: the field, the model's effects, and what was found of both.

    `given_enu_nT` (3,): the field east, north, up, None where only its `strength_nT` is known. `policy`: thresholds of
    the evidence. `track`: changes of the field with the place. `level`: vertical direction, where roll and pitch are
    known and the heading is not. `iron_known`: the model's iron is the instrument's, and a difference is a finding.
    `attitude_std_rad`: error of navigation stated by the model, 0 if none. `attitude_delay_s`: time by which the
    recorded attitude is late, stated by the model or found; the attitude of the recording is moved by it.
    `corrections`: corrections of a wrong reference. `left_out`: effects of the model that are looked for anew.
    `wrong_values`: rare wrong values were found and left out, of which those within the noise remain.
    """

    given_enu_nT: Array | None
    strength_nT: float
    effects: tuple[Effect, ...] = ()
    policy: Policy = STANDARD
    track: FieldTrack | None = None
    level: Level | None = None
    iron_known: bool = True
    attitude_std_rad: float = 0.0
    attitude_delay_s: float = 0.0
    corrections: tuple[ReferenceCorrection, ...] = ()
    left_out: tuple[Effect, ...] = ()
    wrong_values: bool = False

    @property
    def corrected_field_enu_nT(self) -> Array | None:
        """The field (3,) east, north, up that the last correction of the field found; None if the given one holds."""
        found = (done.field_enu_nT for done in reversed(self.corrections))
        return next((field_enu_nT for field_enu_nT in found if field_enu_nT is not None), None)

    def at(self, samples: NDArray[np.bool_]) -> Known:
        """What is known at selected samples (n,)."""
        track, level = self.track, self.level
        if track is not None:
            track = replace(track, change_enu_nT=track.change_enu_nT[samples])
        if level is not None:
            level = Level(level.down[samples], level.dip_rad[samples])
        return replace(self, track=track, level=level)
