"""Kalman filter of the 21 parameters whose measurement noise adapts by fuzzy rules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.vector_filter import KalmanSettings, VectorFilter
from calib.methods.kalman_rescaled import MICROTESLA
from calib.numerics.fuzzy import GRID, RULES, MamdaniRatio
from calib.numerics.kalman import NoiseRule
from calib.settings import Count, NotNegative, Positive


@dataclass(frozen=True)
class KalmanFuzzyCalibrator(VectorFilter):
    """The filter of `kalman_rescaled` with R adapted to the innovations.

    R_k = max(s_k^b R_k-1, floor),  s_k = rules(ROR),  ROR = tr(C_r) / tr(P_r)  ([Li2017] eq. 11 to 16)
    P_r = H (P + Q) H^T + R,  C_r = mean of r r^T over the last n innovations

    n (`window`), b (`exponent`) and the fuzzy sets are not printed. R_k acts from the next sample on. Where H Q H^T
    rules P_r, as with the paper's Q = 1e-5, ROR stays far below one and R would be driven to zero: the floor is ours.
    Where Q is below about 1e-10, R falls and rises again while the start value still rules P_r, and the filter breaks
    down, which the status tells. Between these, R follows noise that changes.
    """

    name: ClassVar[str] = "kalman_fuzzy"
    summary: ClassVar[str] = "kalman_rescaled with measurement noise adapted by Mamdani rules"
    settings: KalmanSettings = MICROTESLA
    window: Count = 50
    exponent: NotNegative = 1.0
    floor_nT2: Positive = 1.0
    rules: MamdaniRatio = RULES

    def noise_rule(self) -> NoiseRule:
        """The rules' table, to the exponent."""
        factors = np.array(self.rules.table()) ** self.exponent
        per_ratio = (GRID - 1) / (2.0 * self.rules.width)
        return NoiseRule(factors, 1.0 - self.rules.width, per_ratio, self.window, self.floor_nT2)
