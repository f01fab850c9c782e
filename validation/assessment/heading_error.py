"""Heading error of a calibration on a level survey, with an interval."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib import Calibration
from calib.result import OFFSET_NAMES, STRENGTH_NAME
from scenarios.arrays import Array
from validation.assessment.input_fields import moved_rms_deg
from validation.assessment.level_flight import LevelFlight
from validation.assessment.policy import ASSESSMENT
from validation.assessment.posterior import Posterior, SensorDraws
from validation.assessment.sensor_model import at_mean_inputs

TURNED = "S_yx"
"""Parameter of fits that determine the sensor's turn in the body."""
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class HeadingError:
    """Rms of the heading error of a calibration over all headings of level flight, deg.

    By true tilt, against the magnetic north of the reference, with currents and temperature as they were in the log.
    value : median, low and high : 95 % interval of the
    posterior, drawn_deg (m,). turn_included : whether a yaw misalignment of the sensor is part of the error.
    """

    drawn_deg: Array
    flight: LevelFlight
    turn_included: bool

    @property
    def value(self) -> float:
        """Return the median."""
        return float(np.median(self.drawn_deg))

    @property
    def low(self) -> float:
        """Return the lower end of the interval."""
        return float(np.quantile(self.drawn_deg, (1.0 - ASSESSMENT.sure) / 2.0))

    @property
    def high(self) -> float:
        """Return the upper end of the interval."""
        return float(np.quantile(self.drawn_deg, (1.0 + ASSESSMENT.sure) / 2.0))

    def below(self, tolerance_deg: float) -> float:
        """Return the probability that the error is below a tolerance."""
        return float(np.mean(self.drawn_deg < tolerance_deg))

    @property
    def dip_deg(self) -> float:
        """Return the dip of the field that the error is for."""
        return float(np.degrees(self.flight.dip_rad))


def heading_error(fit: Calibration, posterior: Posterior | None, flight: LevelFlight) -> HeadingError | None:
    """Return the heading error of a calibration; None without an estimate, and where nothing tells of its errors.

    By the posterior of the recording; by the claimed covariance for a planar calibration, and where the calibration
    determines the sensor's turn and the posterior does not.
    """
    if not fit.has_estimate or fit.corrects_scalar:
        return None
    turned = TURNED in fit.covariance_names
    if fit.determines_z and posterior is not None and (posterior.model.vector or not turned):
        turned = posterior.model.vector
        iron = posterior.drawn.heading_rms_deg(at_mean_inputs(fit, posterior.recording), flight, turned=turned)
        return HeadingError(np.hypot(iron, moved_rms_deg(fit, posterior, flight)), flight, turned)
    if fit.covariance is None:
        return None
    own = _own_flight(fit, flight)
    drawn = _claimed(fit)
    if not fit.determines_z:
        up_nT = -own.strength_nT * float(np.sin(own.dip_rad))
        drawn = replace(
            drawn, offset_nT=drawn.offset_nT - up_nT * np.pad(own.lean.drawn(len(drawn.S)), ((0, 0), (0, 1)))
        )
    return HeadingError(drawn.heading_rms_deg(fit, own, turned=turned), own, turned)


def _own_flight(fit: Calibration, flight: LevelFlight) -> LevelFlight:
    """Return level flight in the scale of a calibration that finds the strength itself, a planar one the horizontal.

    Where no field vector is stated, the planar one's tells the dip too: the accelerometer's needs a field of all axes.
    """
    own_nT = fit.parameters.get(STRENGTH_NAME)
    if own_nT is None:
        return flight
    if fit.determines_z:
        return replace(flight, strength_nT=own_nT)
    if flight.source != "the field vector" and own_nT < flight.strength_nT:
        steep = float(np.arccos(max(own_nT / flight.strength_nT, ASSESSMENT.least_level)))
        flight = replace(flight, dip_rad=float(np.copysign(steep, flight.dip_rad)), source="the horizontal field")
    return replace(flight, strength_nT=own_nT * flight.strength_nT / flight.level_nT)


def _claimed(fit: Calibration) -> SensorDraws:
    """Return draws of the sensor from the claimed covariance; a common scale of the axes turns no heading."""
    assert fit.covariance is not None
    names = fit.covariance_names
    values, axes = np.linalg.eigh(fit.covariance)
    z = np.random.default_rng(0).standard_normal((ASSESSMENT.draws, len(names)))
    moved = (z * np.sqrt(values.clip(0.0))) @ axes.T
    offset, S = np.zeros((len(moved), 3)), np.zeros((len(moved), 3, 3))
    for name, step in zip(names, moved.T, strict=True):
        if name in OFFSET_NAMES:
            offset[:, OFFSET_NAMES.index(name)] = step
        elif name.startswith("S_"):
            i, j = (AXES.index(axis) for axis in name[2:])
            S[:, i, j] = step
            if f"S_{AXES[j]}{AXES[i]}" not in names:
                S[:, j, i] = step
    curves = np.zeros((len(moved), 2, 3))
    return SensorDraws(fit.offset_nT + offset, np.linalg.inv(fit.matrix) + S, curves, 1.0)
