"""Kalman filter of the 21 parameters whose measurement noise adapts by fuzzy rules."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import ClassVar

from calib.methods.kalman import Adapt, KalmanSettings, VectorFilter
from calib.methods.kalman_rescaled import MICROTESLA
from calib.numerics.fuzzy import GRID, RULES, MamdaniRatio


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
    recovers: ClassVar[tuple[str, ...]] = ("full", "pitch")
    settings: KalmanSettings = MICROTESLA
    window: int = 50
    exponent: float = 1.0
    floor_nT2: float = 1.0
    rules: MamdaniRatio = RULES

    def adapt(self) -> Adapt:
        """What gives the next sample's R; it remembers the window, so make one for each run."""
        squares = deque([0.0] * self.window, maxlen=self.window)
        factors = [s**self.exponent for s in self.rules.table()]
        low, step = 1.0 - self.rules.width, (GRID - 1) / (2.0 * self.rules.width)
        seen, total = 0, 0.0

        def adapted(innovation: list[float], predicted_nT2: float, noise_nT2: float) -> float:
            nonlocal seen, total
            x, y, z = innovation
            square = x * x + y * y + z * z
            seen, total = seen + 1, total + square - squares[0]
            squares.append(square)
            if seen < self.window:
                return noise_nT2
            place = round((total / self.window / predicted_nT2 - low) * step)
            adapted_nT2: float = max(noise_nT2 * factors[min(max(place, 0), GRID - 1)], self.floor_nT2)
            return adapted_nT2

        return adapted
