"""One block of the truth that effects act on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """The vehicle and its surroundings at one magnetometer's n sample times (a block of a run).

    ================  =========  =======================================================================
    time_s            (n,)       since the start of the run, evenly spaced
    interval_s        float      sample interval
    pos_enu_m         (n, 3)     of the magnetometer (lever arm included)
    R_wb              (n, 3, 3)  body (FLU) to world (ENU)
    rate_rad_s        (n, 3)     body rate, body frame
    field_enu_nT      (3,)       undisturbed Earth field
    field_nT          (n, 3)     undisturbed field in the body frame, R_wb^T field_enu_nT
    field_rate_nT_s   (n, 3)     its time derivative in the body frame, -rate x field
    temperature_degC  (n,)       of the magnetometer
    current_A         (n, m)     motor currents
    attitude          str        where R_wb comes from: the simulator's truth, or a recording's navigation
    ================  =========  =======================================================================
    """

    time_s: Array
    interval_s: float
    pos_enu_m: Array
    R_wb: Array
    rate_rad_s: Array
    field_enu_nT: Array
    field_nT: Array
    field_rate_nT_s: Array
    temperature_degC: Array
    current_A: Array
    attitude: Literal["truth", "navigation"] = "truth"

    def __len__(self) -> int:
        return len(self.time_s)
