"""Calibration from magnetometer and accelerometer: the field's strength and its dip, without a gyro."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from scipy.linalg import block_diag

from calib.base import Calibrator
from calib.models.dip import DipFit, DipSamples
from calib.models.ellipsoid import FULL_SLOTS, SYMMETRIC_NAMES, SYMMETRIC_SLOTS, UPPER
from calib.models.vector import SOFT_IRON_NAMES
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array

FIRST_NOISE, FIRST_DIP_NOISE = 3e-3, 2e-2
"""Standard deviations of strength and dip in the first round, in units of F."""


@dataclass(frozen=True)
class StrengthDip(Calibrator):
    """Offset and S from the field's strength and its angle to gravity; no gyro, no attitude.

    m = S h + b:  |h| = F,  a . h = F sin I,  a = f / |f|, f the specific force

    min over b, S, I of the weighted squares of both residuals; the weights are fitted, the residual of the dip counted
    as coloured since a vehicle accelerates. I is that of the reference vector where one is known, else fitted.
    `soft_iron`: "full" with nine entries in the axes of the accelerometer, or "symmetric" with six, for small tilts of
    a magnetometer mounted along the accelerometer's axes. [Kanatani1994] for the weights.
    """

    name: ClassVar[str] = "strength_dip"
    summary: ClassVar[str] = "offset and matrix from strength and dip: magnetometer and accelerometer, no gyro"
    needs: ClassVar[tuple[str, ...]] = ("accel",)
    min_samples: ClassVar[int] = 20
    soft_iron: Literal["full", "symmetric"] = "full"
    rounds: Count = 8
    tolerance: Positive = 0.01

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        assert recording.accel_m_s2 is not None
        order = np.argsort(recording.time_s, kind="stable")
        middle_nT, F = recording.mag_nT.mean(axis=0), reference.strength_nT
        force = recording.accel_m_s2[order]
        up = force / np.linalg.norm(force, axis=1)[:, None]
        x = (recording.mag_nT[order] - middle_nT) / F
        samples = DipSamples(x, up, self._slots, _inclination(reference), FIRST_NOISE, FIRST_DIP_NOISE)
        return self._calibration(DipFit.of(samples, self.rounds, self.tolerance), middle_nT, F)

    @property
    def _slots(self) -> Array:
        return FULL_SLOTS if self.soft_iron == "full" else SYMMETRIC_SLOTS

    def _calibration(self, fit: DipFit, middle_nT: Array, strength_nT: float) -> Calibration:
        """The fit in nT; dS = -S dT S."""
        centre, T, inclination = fit.samples.parts(fit.theta)
        S = np.asarray(np.linalg.inv(T))
        slopes = -(S @ self._slots @ S)
        if self.soft_iron == "full":
            names, entries, to_soft = SOFT_IRON_NAMES, S.ravel(), slopes.reshape(-1, 9).T
        else:
            names, entries, to_soft = SYMMETRIC_NAMES, S[UPPER], slopes[:, *UPPER].T
        known = len(fit.theta)
        jacobian = block_diag(strength_nT * np.eye(3), to_soft, np.eye(1))[:known, :known]
        offset_nT = middle_nT + strength_nT * centre
        every = (*OFFSET_NAMES, *names, "inclination_rad")
        values = dict(zip(every, [*offset_nT.tolist(), *entries.tolist(), inclination], strict=True))
        noises = {"noise_std_nT": fit.samples.noise * strength_nT, "dip_noise_std_rad": fit.samples.dip_noise}
        return Calibration(
            name=self.name,
            status=Status.settled(fit.settled, "the weights of strength and dip did not settle: record longer"),
            offset_nT=offset_nT,
            matrix=T,
            parameters=values | noises,
            covariance=np.asarray(jacobian @ fit.covariance @ jacobian.T),
            covariance_names=every[:known],
            history=fit.history,
        )


def _inclination(reference: Reference) -> float | None:
    """The reference vector's angle above the horizon, rad; None without a vector."""
    if reference.field_enu_nT is None:
        return None
    east, north, up = reference.field_enu_nT
    return float(np.arctan2(up, np.hypot(east, north)))
