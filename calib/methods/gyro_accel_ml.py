"""Maximum likelihood with attitudes linked by the gyro and levelled by the accelerometer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from calib.families.gyro_linked import GyroLinked, LinkedFit, rms
from calib.models.levelled import Attitudes, Levelled
from calib.models.linked import LinkedSamples
from calib.numerics.colour import inflation
from calib.numerics.damped import minimised
from calib.numerics.noise import white_noise_std
from calib.reference import Reference
from calib.result import Status
from calib.settings import Positive
from recordings import Recording
from scenarios.arrays import Array

LEAST_LEVEL_M_S2 = 1e-6
"""Noise of an accelerometer that shows less."""
LEVEL_SETTLED = 0.05
"""Change of the logarithm of its noise at which that has settled: what the noise of a noise does to an offset is of
second order."""
MOST_UPRIGHT = 0.98
"""Of the field's cosine with up: nearer, at some 11 degrees, the two directions do not make an attitude."""
LEVEL_NAMES = ("inclination_rad", "gravity_m_s2", *(f"accel_bias_{axis}_m_s2" for axis in "xyz"))


@dataclass(frozen=True)
class GyroAccelMl(GyroLinked):
    """As `gyro_ml`, with whole attitudes instead of directions, levelled by the accelerometer.

    a_i = g Q_i z + e + l_i,  u_i = Q_i h,  Q_(i+1) = exp(-[(omega_i - beta) dt_i]x + w_i) Q_i

    Starts from the result of `gyro_ml` and keeps the noises. The angle between field and up, the accelerometer's bias e
    and gravity g are fitted too; g deviates from standard gravity by `gravity_std_m_s2`, the uncertainty of the
    accelerometer's scale. l are the vehicle's accelerations with the sensor's noise, not white: the variance of l is
    the largest of L var(means over blocks of L samples), so the accelerometer of an accelerating vehicle has little
    weight instead of a wrong influence.

    `inclination_std_deg`: uncertainty of the inclination of the reference vector; None: the inclination is fitted.
    """

    name: ClassVar[str] = "gyro_accel_ml"
    summary: ClassVar[str] = "as gyro_ml, levelled by the accelerometer, for vehicles that accelerate little"
    needs: ClassVar[tuple[str, ...]] = ("gyro", "accel")
    gravity_std_m_s2: Positive = 0.01
    inclination_std_deg: Positive | None = None

    @property
    def _beside(self) -> tuple[str, ...]:
        return LEVEL_NAMES

    def _refined(self, fit: LinkedFit, recording: Recording, reference: Reference) -> LinkedFit | Status:
        assert recording.accel_m_s2 is not None
        assert isinstance(fit.chain, LinkedSamples)
        accel_m_s2 = recording.accel_m_s2[np.argsort(recording.time_s, kind="stable")]
        towards = np.einsum("ni,ni->n", fit.found.point.estimate.directions, accel_m_s2)
        size = np.linalg.norm(accel_m_s2, axis=1)
        if not np.mean(np.abs(towards)) < MOST_UPRIGHT * np.mean(size):
            return Status("not_applicable", "the field is as upright as gravity: take gyro_ml")
        noise = float(np.sqrt(fit.found.normal.variance))
        least = max(rms(white_noise_std(accel_m_s2)), LEAST_LEVEL_M_S2)
        level = max(lasting(np.column_stack((towards, size))), least)
        known = self._inclination(reference)
        levelled = Levelled(fit.chain, accel_m_s2, noise, level, self.gravity_std_m_s2, known)
        return self._levelled(fit, levelled, least)

    def _inclination(self, reference: Reference) -> tuple[float, float] | None:
        if self.inclination_std_deg is None or reference.field_enu_nT is None:
            return None
        east, north, up = reference.field_enu_nT
        return float(np.arctan2(up, np.hypot(east, north))), float(np.radians(self.inclination_std_deg))

    def _levelled(self, fit: LinkedFit, levelled: Levelled, least: float) -> LinkedFit:
        """Minimum and noise of the accelerometer in turn, until that settles."""
        point = levelled.settled(Attitudes.of(fit.found.point.estimate, levelled.accel_m_s2))
        history, change = fit.history, np.inf
        for _ in range(self.rounds):
            found = minimised(levelled, point, self.iterations, self.tolerance)
            history += found.history
            level = max(lasting(levelled.accel_m_s2 - found.point.estimate.forces()), least)
            change = abs(float(np.log(level / levelled.level_m_s2)))
            if change < LEVEL_SETTLED:
                break
            levelled = levelled.with_level(level)
            point = levelled.settled(found.point.estimate)
        settled = fit.settled and found.settled and change < LEVEL_SETTLED
        told = {"accel_noise_std_m_s2": levelled.level_m_s2}
        return replace(fit, chain=levelled, found=found, history=history, settled=settled, told=told)


def lasting(values: Array) -> float:
    """Standard deviation of white noise whose means over some block length scatter as those of values (n, k)."""
    return float(np.sqrt(np.mean(np.var(values, axis=0)) * inflation(values)))
