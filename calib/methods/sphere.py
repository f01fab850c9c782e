"""Sphere fit: offset and one scale, from the field's strength alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calib.base import Calibrator
from calib.models.quadric import design, shape_matrix
from calib.observability import MAX_STD_FRACTION, planar_status
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SphereCalibrator(Calibrator):
    """Offset b and one scale s by linear least squares; needs no attitude and knows no soft iron.

    m = s h + b, |h| = F:  |m|^2 = 2 m . b + (s^2 F^2 - |b|^2), linear in (b, s^2 F^2 - |b|^2)

    The claimed covariance is a mean square error: noise, and the bias by the soft iron that the model leaves out,
    as the misfit shows it; a plain least-squares covariance would claim a few nT where the error is thousands.
    """

    name: ClassVar[str] = "sphere"
    summary: ClassVar[str] = "offset and one scale from the field strength; no attitude, no soft iron"
    min_samples: ClassVar[int] = 12

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        middle = recording.mag_nT.mean(axis=0)
        size = float(np.sqrt(((recording.mag_nT - middle) ** 2).sum(axis=1).mean()))
        x = (recording.mag_nT - middle) / size
        flat = planar_status(recording.mag_nT, 0.0)
        if flat is not None:
            return flat
        rows = np.concatenate((2 * x, np.ones((len(x), 1))), axis=1)
        q, r = np.linalg.qr(rows)
        squared = (x * x).sum(axis=1)
        solution = np.linalg.solve(r, q.T @ squared)
        misfit = squared - rows @ solution
        radius = float(np.sqrt(solution[3] + solution[:3] @ solution[:3]))
        noise_std = float(np.sqrt(misfit @ misfit / (len(x) - 4))) / (2 * radius)
        covariance, bias = _covariance(x, q, r, solution, misfit)
        status = (
            planar_status(recording.mag_nT, noise_std * size)
            or _soft_iron_status(bias * size, reference.strength_nT)
            or Status("ok")
        )
        return self._calibration(
            middle, size, np.append(solution[:3], radius), covariance, noise_std, reference.strength_nT, status
        )

    def _calibration(
        self,
        middle: Array,
        size: float,
        sphere: Array,
        covariance: Array,
        noise_std: float,
        strength_nT: float,
        status: Status,
    ) -> Calibration:
        centre, radius = sphere[:3], float(sphere[3])
        offset_nT, scale = middle + size * centre, size * radius / strength_nT
        jacobian = np.zeros((4, 4))
        jacobian[:3, :3] = size * np.eye(3)
        jacobian[3] = np.append(centre, 0.5) / radius * size / strength_nT
        names = (*OFFSET_NAMES, "scale")
        parameters = dict(zip(names, (*offset_nT.tolist(), scale), strict=True)) | {"noise_std_nT": noise_std * size}
        return Calibration(
            name=self.name,
            status=status,
            offset_nT=offset_nT,
            matrix=np.eye(3) / scale,
            parameters=parameters,
            covariance=jacobian @ covariance @ jacobian.T,
            covariance_names=names,
        )


def _soft_iron_status(bias_nT: float, strength_nT: float) -> Status | None:
    """Unobservable when soft iron moves the centre by more than the covariance of a usable fit may."""
    if bias_nT <= MAX_STD_FRACTION * strength_nT:
        return None
    return Status(
        "unobservable",
        "the measurements are not on a sphere: soft iron moves its centre by about "
        f"{bias_nT:.3g} nT on this motion; use ellipsoid, or cover all attitudes evenly",
    )


def _covariance(x: Array, q: Array, r: Array, solution: Array, misfit: Array) -> tuple[Array, float]:
    """Mean square error (4, 4) of the linear solution, and the centre's bias in it, by the soft iron left out.

    C = sigma^2 R^-1 R^-T + k beta beta^T,  beta = theta - (A^-1 c', d'),  k = max(0, 1 - 5 sigma^2 / |Z' gamma|^2)
    (c', d') = theta - R^-1 Q^T Z gamma,  A = I - Gamma

    Z the five trace-free quadratic terms, Z' their part clear of the fitted columns, gamma their coefficients in the
    misfit (Gamma as a matrix); k shrinks what noise alone would explain (5 sigma^2) to nothing.
    """
    quadratic = design(x)[:, :6]
    softness = np.column_stack((quadratic[:, 0] - quadratic[:, 2], quadratic[:, 1] - quadratic[:, 2], quadratic[:, 3:]))
    alias = q.T @ softness
    clear = softness - q @ alias
    gamma = np.linalg.lstsq(clear, misfit, rcond=None)[0]
    explained = float(gamma @ (clear.T @ misfit))
    variance = max(float(misfit @ misfit) - explained, 0.0) / (len(x) - 9)
    share = max(0.0, 1.0 - 5.0 * variance / explained) if explained > 0 else 0.0
    inverse = np.linalg.inv(r)
    full = solution - inverse @ alias @ gamma
    soft = shape_matrix(np.array([gamma[0], gamma[1], -gamma[0] - gamma[1], *gamma[2:]]))
    full[:3] = np.linalg.solve(np.eye(3) - soft, full[:3])
    bias = np.sqrt(share) * (solution - full)
    return variance * inverse @ inverse.T + np.outer(bias, bias), float(np.linalg.norm(bias[:3]))
