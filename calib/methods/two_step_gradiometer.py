"""Two-step calibration of a magnetometer array: each sensor alone, then the turns between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.gradiometer import ArrayEstimate, GradiometerCalibrator
from calib.methods.ellipsoid import EllipsoidCalibrator
from calib.models.sensor_array import ArrayObjective, parameters_of
from calib.reference import Reference
from calib.result import Calibration, Status
from recordings import Recording
from scenarios.arrays import Array


@dataclass(frozen=True)
class TwoStepGradiometer(GradiometerCalibrator):
    """Ellipsoid fit of each sensor, then the turn of each corrected field onto sensor 1's.

    1: h_i = (K_i C_i)^-1 (m_i - b_i) from |h_i| = F
    2: T_i = arg min sum |T_i h_i - h_1|^2, by singular value decomposition [Wahba1965, Markley1988]

    What [Ding2021] compares its one step with. The second step takes the first for exact, so that offset and axes of a
    sensor do not profit from the others. The claimed covariance is that of the joint objective at the result: too small
    for this method.
    """

    name: ClassVar[str] = "two_step_gradiometer"
    summary: ClassVar[str] = "ellipsoid fit of each sensor of an array, then the turns between them"
    polish: bool = False

    def search(
        self, task: ArrayObjective, recording: Recording, reference: Reference, rng: np.random.Generator
    ) -> ArrayEstimate:
        """Both steps."""
        return two_steps(recording, reference)


def two_steps(recording: Recording, reference: Reference) -> ArrayEstimate:
    """Parameters of the array by the two steps, or the status of the sensor whose ellipsoid fails."""
    assert recording.array_mag_nT is not None
    count = len(recording.array_mag_nT)
    single = [EllipsoidCalibrator(robust=False).fit(recording.sensor(i), reference) for i in range(count)]
    for i, fit in enumerate(single):
        if fit.covariance is None or fit.status.kind == "not_applicable":
            return ArrayEstimate(
                np.zeros(12 * count), (), Status(fit.status.kind, f"sensor {i + 1}: {fit.status.reason}")
            )
    first = _triangular(single[0])
    field = first @ (recording.array_mag_nT[0] - single[0].offset_nT).T
    parameters = []
    for fit, mag_nT in zip(single, recording.array_mag_nT, strict=True):
        matrix = _turn(fit.matrix @ (mag_nT - fit.offset_nT).T, field) @ fit.matrix
        parameters.append(parameters_of(fit.offset_nT / reference.strength_nT, matrix))
    parameters[0][9:] = 0.0
    return ArrayEstimate(np.concatenate(parameters))


def _triangular(fit: Calibration) -> Array:
    """(K C)^-1: the fit's matrix up to a turn, upper triangular."""
    r = np.linalg.qr(fit.matrix).R
    return np.asarray(np.sign(np.diag(r))[:, None] * r)


def _turn(field: Array, reference: Array) -> Array:
    """The rotation (3, 3) that takes vectors (3, n) closest to others (3, n)."""
    u, _, vt = np.linalg.svd(reference @ field.T)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)
