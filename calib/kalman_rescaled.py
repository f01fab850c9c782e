"""Kalman filter of the 21 parameters with T_p in microtesla."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.kalman import KalmanSettings, solve
from calib.reference import Reference
from calib.result import Calibration
from sim.dataset import Recording

MICROTESLA = KalmanSettings(offset_unit_nT=1000.0)


@dataclass(frozen=True)
class KalmanRescaledCalibrator(Calibrator):
    """The filter of `kalman` with the rescaled observation matrix: T_p in microtesla.

    H = [1000 I3 | T_3x9 | dT_3x9]  ([Li2017] eq. 10)

    The same prior variance of 100 now stands for 10 microtesla, so T_p is free to move. Q = 1e-5 a sample makes the
    filter forget: set `settings` to a `state_variance` of 0 and a `noise_variance_nT2` of the sensor for constant iron.
    """

    name: ClassVar[str] = "kalman_rescaled"
    summary: ClassVar[str] = "Kalman filter of 21 parameters, T_p in microtesla so that it converges"
    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector")
    min_samples: ClassVar[int] = 21
    sequential: ClassVar[bool] = True
    recovers: ClassVar[tuple[str, ...]] = ("full", "pitch")
    tolerance_nT: ClassVar[float] = 5.0
    tolerance_matrix: ClassVar[float] = 2e-4
    unit_free: ClassVar[bool] = False
    settings: KalmanSettings = MICROTESLA
    attitude_std_rad: float = 3.5e-4

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        return solve(self.name, recording, reference, self.settings, self.attitude_std_rad)
