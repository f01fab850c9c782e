"""Kalman filter of the 21 parameters with T_p in microtesla."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.vector_filter import MICROTESLA_NT, KalmanSettings, VectorFilter
from calib.numerics.kalman import STEADY, NoiseRule

MICROTESLA = KalmanSettings(offset_unit_nT=MICROTESLA_NT)


@dataclass(frozen=True)
class KalmanRescaledCalibrator(VectorFilter):
    """The filter of `kalman` with the rescaled observation matrix: T_p in microtesla.

    H = [1000 I3 | T_3x9 | dT_3x9]  ([Li2017] eq. 10)

    The same prior variance of 100 now stands for 10 microtesla, so T_p is free to move. Q = 1e-5 a sample makes the
    filter forget: set `settings` to a `state_variance` of 0 and a `noise_variance_nT2` of the sensor for constant iron.
    """

    name: ClassVar[str] = "kalman_rescaled"
    summary: ClassVar[str] = "Kalman filter of 21 parameters, T_p in microtesla so that it converges"
    settings: KalmanSettings = MICROTESLA

    def noise_rule(self) -> NoiseRule:
        """R stays."""
        return STEADY
