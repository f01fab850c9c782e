"""Tolles-Lawson compensation of a scalar magnetometer by a vector one beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from scipy.signal import butter, sosfiltfilt

from calib.base import Calibrator
from calib.numerics.noise import white_noise_std
from calib.numerics.rates import smoothed_derivative
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Band, NotNegative
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


@dataclass(frozen=True)
class TollesLawsonCalibrator(Calibrator):
    """16 or 18 coefficients of the vehicle's field along the Earth's, at a scalar magnetometer beside the vector one.

    |T_s| - F = p . u + F u^T A u + F u^T B du/dt,  u = m / |m|  [TollesLawson1950], [Leliak1961]

    p permanent (3), A induced (6, symmetric), B eddy (9). Both sides pass the band `band_hz` (at most 0.45 and 0.9 of
    the Nyquist frequency), which takes out the Earth's own changes, and the coefficients follow by ridge regression,
    `ridge` in units of the squared length of a column. The recording needs the scalar magnetometer as the channel
    `scalar_nT`. The coefficients belong to the place of the scalar sensor, so offset and matrix of the vector sensor
    stay raw (the identity); `compensated` gives the corrected strength. The vector sensor's own errors stay in it, and
    the second order of the vehicle's field, |dT|^2 / 2F. The claimed covariance takes the noise for white within
    the band.
    """

    name: ClassVar[str] = "tolles_lawson"
    summary: ClassVar[str] = "Tolles-Lawson terms of a scalar magnetometer (channel scalar_nT) beside the vector one"
    needs: ClassVar[tuple[str, ...]] = ("scalar",)
    min_samples: ClassVar[int] = 64
    sequential: ClassVar[bool] = True
    terms: Literal[16, 18] = 16
    band_hz: Band = (0.01, 0.5)
    ridge: NotNegative = 1e-9

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        names = tuple(n for n in NAMES if self.terms == 18 or n not in REDUNDANT)
        kept = [NAMES.index(n) for n in names]
        columns = band_passed(terms(recording, reference.strength_nT)[:, kept], recording.time_s, self.band_hz)
        target = band_passed(recording.channels[CHANNEL][:, None], recording.time_s, self.band_hz)[:, 0]
        solution, root, condition = ridge_solution(columns, target, self.ridge)
        residual = target - columns @ solution
        low, high = band(recording.time_s, self.band_hz)
        variance = float(residual @ residual) / (len(target) * (high - low))
        told = {
            "improvement_ratio": float(target.std() / max(residual.std(), 1e-12)),
            "condition_number": condition,
            "noise_std_nT": float(white_noise_std(recording.mag_nT).max()),
        }
        return Calibration(
            name=self.name,
            status=Status("ok"),
            parameters=dict(zip(names, solution.tolist(), strict=True)) | told,
            covariance=variance * root @ root.T,
            covariance_names=names,
        )


def ridge_solution(columns: Array, target: Array, ridge: float) -> tuple[Array, Array, float]:
    """Ridge regression: solution (p,), root (p, p) of its covariance for noise of variance one, condition number.

    ridge: in units of the squared length of a column.
    """
    size = np.linalg.norm(columns, axis=0)
    u, singular, vt = np.linalg.svd(columns / size, full_matrices=False)
    gain = singular / (singular**2 + ridge)
    root = (vt.T * gain) / size[:, None]
    return root @ (u.T @ target), root, float(singular[0] / singular[-1])


def terms(recording: Recording, strength_nT: float) -> Array:
    """The 18 terms (n, 18) in the order of NAMES: u, F u_i u_j, F u_i du_j/dt."""
    u = recording.mag_nT / np.linalg.norm(recording.mag_nT, axis=1)[:, None]
    du = smoothed_derivative(u, recording.time_s)
    twice = [strength_nT * u[:, i] * u[:, j] * (1.0 if i == j else 2.0) for i, j in INDUCED]
    eddy = (strength_nT * u[:, :, None] * du[:, None, :]).reshape(-1, 9)
    return np.column_stack((u, *twice, eddy))


def band(time_s: Array, band_hz: tuple[float, float]) -> tuple[float, float]:
    """The band's edges as fractions of the Nyquist frequency, where they exist at this sample rate."""
    nyquist_hz = 0.5 * (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    return min(band_hz[0] / nyquist_hz, 0.45), min(band_hz[1] / nyquist_hz, 0.9)


def band_passed(values: Array, time_s: Array, band_hz: tuple[float, float]) -> Array:
    """Values (n, k) through a second-order Butterworth band, forwards and backwards, without delay."""
    sections = butter(2, band(time_s, band_hz), "bandpass", output="sos")
    return np.asarray(sosfiltfilt(sections, values, axis=0))


def compensated(fit: Calibration, recording: Recording, reference: Reference) -> Array:
    """The scalar magnetometer's strength (n,), nT, without the vehicle's field that the fit found."""
    coefficients = np.array([fit.parameters.get(name, 0.0) for name in NAMES])
    return np.asarray(recording.channels[CHANNEL] - terms(recording, reference.strength_nT) @ coefficients)
