"""Tolles-Lawson terms: the vehicle's field along the Earth's, at a scalar magnetometer beside the vector one.

|T_s| - F = p . u + F u^T A u + F u^T B du/dt,  u = m / |m|  [TollesLawson1950], [Leliak1961]

p permanent (3), A induced (6, symmetric), B eddy (9)
"""

from __future__ import annotations

import numpy as np

from calib.numerics.bands import low_passed
from calib.numerics.rates import smoothed_derivative
from calib.result import Calibration
from recordings import Recording
from scenarios.arrays import Array

CHANNEL = "scalar_nT"
INDUCED = tuple((i, j) for i in range(3) for j in range(i, 3))
NAMES = (
    *(f"permanent_{i}_nT" for i in "xyz"),
    *(f"induced_{'xyz'[i]}{'xyz'[j]}" for i, j in INDUCED),
    *(f"eddy_{i}{j}_s" for i in "xyz" for j in "xyz"),
)
REDUNDANT = ("induced_zz", "eddy_zz_s")
"""Left out of 18 terms to give 16: u.u = 1 and u.du/dt = 0 tie them to the others."""
STRENGTH, LOW, HIGH = "reference_nT", "band_low_hz", "band_high_hz"
"""Parameters of a fit that the correction needs: F, and the band."""


def directions(recording: Recording) -> Array:
    """Direction u (n, 3) of the measured field."""
    return np.asarray(recording.mag_nT / np.linalg.norm(recording.mag_nT, axis=1)[:, None])


def terms(recording: Recording, strength_nT: float) -> Array:
    """The 18 terms (n, 18) in the order of NAMES: u, F u_i u_j, F u_i du_j/dt."""
    u = directions(recording)
    du = smoothed_derivative(u, recording.time_s)
    twice = [strength_nT * u[:, i] * u[:, j] * (1.0 if i == j else 2.0) for i, j in INDUCED]
    eddy = (strength_nT * u[:, :, None] * du[:, None, :]).reshape(-1, 9)
    return np.column_stack((u, *twice, eddy))


def compensated(fit: Calibration, recording: Recording) -> Array:
    """The scalar magnetometer's strength (n,), nT, without the vehicle's field that the fit found.

    The vehicle's field is low-passed, see `bands.low_passed`: above, the terms hold the vector sensor's noise alone.
    """
    told = fit.parameters
    coefficients = np.array([told.get(name, 0.0) for name in NAMES])
    vehicle_nT = terms(recording, told[STRENGTH]) @ coefficients
    smooth_nT = low_passed(vehicle_nT[:, None], recording.time_s, (told[LOW], told[HIGH]))[:, 0]
    return np.asarray(recording.channels[CHANNEL] - smooth_nT)
