"""The calibration that an autopilot had in force when a log was made, which the reader of the log undid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class AppliedCalibration:
    """h = matrix (m - offset_nT): m the recording's field, h the field as the autopilot used it, body frame (FLU), nT.

    Parameters
    ----------
    autopilot : "ardupilot", "px4", "inav", ...; with `compass` this names the parameters.
    compass : the magnetometer's number as the parameters count: COMPASS_OFS_X is 1, CAL_MAG0_XOFF is 0.
    offset_nT : (3,). matrix : (3, 3).
    parameters : all parameters of this magnetometer by the autopilot's names, as they were in force: offset, scale,
        rotation, device number, motor compensation.
    undone : whether the columns of the log were changed by the inverse; else they are raw in the log already.
    """

    autopilot: str
    compass: int
    offset_nT: Array = field(default_factory=lambda: np.zeros(3))
    matrix: Array = field(default_factory=lambda: np.eye(3))
    parameters: Mapping[str, float] = field(default_factory=dict)
    undone: bool = True
