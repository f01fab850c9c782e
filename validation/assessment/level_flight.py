"""Level flight on all headings, and the heading errors of a calibration in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib import Reference
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.lean import Lean
from validation.assessment.policy import ASSESSMENT

DipSource = Literal["the field vector", "the accelerometer", "the horizontal field", "assumed"]
HEADINGS = 24
"""Headings of level flight, evenly spaced: the error has at most two cycles a turn to first order."""


@dataclass(frozen=True)
class LevelFlight:
    """Level flight in a field of a strength and a dip (positive downwards), and how the dip is known.

    lean : the vehicle's mean tilt in the recording, which level flight has not.
    """

    strength_nT: float
    dip_rad: float
    source: DipSource
    lean: Lean

    @property
    def heading_rad(self) -> Array:
        """Return the headings (HEADINGS,), clockwise from magnetic north."""
        return np.asarray(2.0 * np.pi * np.arange(HEADINGS) / HEADINGS)

    @property
    def level_nT(self) -> float:
        """Return the horizontal part of the field."""
        return self.strength_nT * max(float(np.cos(self.dip_rad)), ASSESSMENT.least_level)

    @property
    def field_nT(self) -> Array:
        """Return the field (HEADINGS, 3) in the body frame, forward, left, up."""
        down = -self.strength_nT * np.sin(self.dip_rad)
        heading = self.heading_rad
        return np.column_stack(
            (self.level_nT * np.cos(heading), self.level_nT * np.sin(heading), np.full(HEADINGS, down))
        )

    @property
    def across(self) -> Array:
        """Return rows (HEADINGS, 3): degrees of heading a nT of the corrected field's error."""
        heading = self.heading_rad
        unit = np.column_stack((-np.sin(heading), np.cos(heading), np.zeros(HEADINGS)))
        return np.asarray(np.degrees(unit / self.level_nT))

    def rms_deg(self, corrected_nT: Array) -> Array:
        """Return the rms (m,) over the headings of the error of corrected fields (m, HEADINGS, 3)."""
        error = np.arctan2(corrected_nT[..., 1], corrected_nT[..., 0]) - self.heading_rad
        return np.asarray(np.degrees(np.sqrt(np.mean(np.angle(np.exp(1j * error)) ** 2, axis=-1))))


def level_flight(recording: Recording, reference: Reference, field_nT: Array) -> LevelFlight:
    """Return level flight at the place of a recording; field_nT : corrected field (n, 3) beside an accelerometer.

    The dip is that of the reference's vector, else of the field against gravity, else ASSESSMENT.dip_deg.
    """
    strength, lean = reference.strength_nT, Lean.of(recording)
    if reference.field_enu_nT is not None:
        east, north, up = reference.field_enu_nT
        return LevelFlight(strength, float(np.arctan2(-up, np.hypot(east, north))), "the field vector", lean)
    if recording.accel_m_s2 is not None:
        force = np.linalg.norm(recording.accel_m_s2, axis=1)[:, None]
        upward = recording.accel_m_s2 / np.where(force > 0, force, np.nan)
        along = np.einsum("ni,ni->n", upward, field_nT) / np.linalg.norm(field_nT, axis=1)
        dip = float(np.nanmedian(np.arcsin(np.clip(-along, -1.0, 1.0))))
        if np.isfinite(dip):
            return LevelFlight(strength, dip, "the accelerometer", lean)
    return LevelFlight(strength, float(np.radians(ASSESSMENT.dip_deg)), "assumed", lean)
