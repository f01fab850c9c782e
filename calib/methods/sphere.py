"""Sphere fit: offset and one scale, from the field's strength alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.models.ellipsoid import Standardised
from calib.models.sphere import SphereFit
from calib.observability import MAX_STD_FRACTION
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from recordings import Recording
from scenarios.text import figure

NAMES = (*OFFSET_NAMES, "scale")
CAVEAT_FRACTION = 0.001
"""An "ok" names the soft iron that it cannot rule out where that may move the centre by more than this fraction of the
field: a tenth of what makes it unobservable, and 0.1 degrees of heading."""


@dataclass(frozen=True)
class SphereCalibrator(Calibrator):
    """Offset b and one scale s by linear least squares; needs no attitude and knows no soft iron.

    m = s h + b, |h| = F:  |m|^2 = 2 m . b + (s^2 F^2 - |b|^2), linear in (b, s^2 F^2 - |b|^2)

    The claimed covariance is a mean square error: noise, and the bias by the soft iron that the model leaves out,
    as the misfit shows it; a plain least-squares covariance would claim a few nT where the error is thousands.
    """

    name: ClassVar[str] = "sphere"
    summary: ClassVar[str] = "offset and one scale from the field strength; no attitude, no soft iron"
    min_samples: ClassVar[int] = 10

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        scaled = Standardised.of(recording.mag_nT)
        fit = SphereFit.of(scaled.x)
        covariance, bias, unknown = fit.mean_square_error()
        status = _soft_iron_status(bias / fit.radius, unknown / fit.radius, reference.strength_nT)
        size, gain = scaled.scale_nT, scaled.scale_nT / reference.strength_nT
        offset_nT, scale = scaled.middle_nT + size * fit.centre, gain * fit.radius
        jacobian = np.diag([size, size, size, 0.0])
        jacobian[3] = np.append(fit.centre, 0.5) / fit.radius * gain
        values = dict(zip(NAMES, (*offset_nT.tolist(), scale), strict=True))
        return Calibration(
            name=self.name,
            status=status,
            offset_nT=offset_nT,
            matrix=np.eye(3) / scale,
            parameters=values | {"noise_std_nT": fit.noise_std * size},
            covariance=jacobian @ covariance @ jacobian.T,
            covariance_names=NAMES,
        )


def _soft_iron_status(bias: float, unknown: float, strength_nT: float) -> Status:
    """Unobservable when soft iron would move the centre, in radii, by more than the covariance of a usable fit may.

    Ok with a caveat where it may move it by more than CAVEAT_FRACTION: by a bias that shows, or unseen.
    """
    moved = f"which would move its centre by about {figure(max(bias, unknown) * strength_nT)} nT on this motion"
    if bias > MAX_STD_FRACTION:
        what = f"the measurements are not on a sphere: this method cannot rule out soft iron, {moved}"
        return Status("unobservable", f"{what}; use ellipsoid, or cover all attitudes evenly")
    if max(bias, unknown) > CAVEAT_FRACTION:
        return Status("ok", f"this method cannot rule out soft iron, {moved}; compare it with ellipsoid")
    return Status("ok")
