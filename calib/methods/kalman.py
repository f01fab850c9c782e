"""Kalman filter of the 21 parameters of the vector model, in the paper's own scaling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.vector_filter import VectorFilter
from calib.numerics.kalman import STEADY, NoiseRule


@dataclass(frozen=True)
class KalmanCalibrator(VectorFilter):
    """The filter as [Li2017] prints it first, with T_p in nT.

    T_p in nT has a prior standard deviation of 10 nT beside columns of 10^4: it practically stays where it began, as
    the paper finds; the status says so.
    """

    name: ClassVar[str] = "kalman"
    summary: ClassVar[str] = "Kalman filter of 21 parameters, T_p in nT: the paper's baseline, whose T_p hardly moves"

    def noise_rule(self) -> NoiseRule:
        """R stays."""
        return STEADY
