"""What ArduPilot did to a compass's field before it logged the field, and its inverse."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from recordings.applied import AppliedCalibration
from recordings.body_frame import DOWN
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.rotations import ARDUPILOT
from scenarios.arrays import Array

MILLIGAUSS_NT = 100.0
"""Nanotesla in a milligauss."""
LARGEST_SCALE = 1.5
"""COMPASS_SCALE counts from 1 / LARGEST_SCALE to LARGEST_SCALE; else the autopilot takes 1."""
WORST_CONDITION = 100.0
"""Condition number of M above which the calibration is no calibration, and is not undone."""
COMPASSES = (1, 2, 3)
"""The compasses that have calibration parameters."""
_COMMON = r"AHRS_ORIENTATION|COMPASS_(MOTCT|PMOT_EN|PMOT_EXP|CUS_\w+|OFFS_MAX)|CUST_ROT\w*"


def suffix(compass: int) -> str:
    """Return what the parameters of a compass have after their name: nothing for the first."""
    return "" if compass == 1 else str(compass)


def own_parameters(parameters: Parameters, compass: int) -> dict[str, float]:
    """Return the last values of all parameters that say how a compass is mounted, calibrated and compensated."""
    own = suffix(compass)
    kinds = rf"(OFS|DIA|ODI|MOT){own}_[XYZ]|(SCALE|ORIENT|DEV_ID|USE|EXTERN){own}|PRIO{compass}_ID"
    first = r"|EXTERNAL|PMOT\d+_[XYZ]" if compass == 1 else ""
    wanted = re.compile(rf"COMPASS_({kinds}{first})|{_COMMON}")
    return {name: value for name, value in sorted(parameters.last.items()) if wanted.fullmatch(name)}


def calibration_names(compass: int) -> list[str]:
    """Return the parameters that act on the logged field of a compass, but for the motors'."""
    own = suffix(compass)
    return [f"COMPASS_{kind}{own}_{axis}" for kind in ("OFS", "DIA", "ODI") for axis in "XYZ"] + [f"COMPASS_SCALE{own}"]


@dataclass(frozen=True, eq=False)
class CompassCalibration:
    """field = M s (R raw + o) + k p, in mG, body frame FRD [ArduPilot: AP_Compass_Backend.cpp, correct_field].

    R raw is the field in the body frame before any calibration, o the offset, s the scale, M the symmetric matrix of
    soft iron, k p the motors' term, which the autopilot adds last; firmware before that of COMPASS_PMOT adds the term
    to the offset: field = M s (R raw + o + k p).

    Parameters
    ----------
    compass : its number in the parameters, from 1. offset_mG : o (3,). matrix : M s (3, 3).
    motors_first : whether the motors' term comes before M.
    """

    compass: int
    offset_mG: Array = field(default_factory=lambda: np.zeros(3))
    matrix: Array = field(default_factory=lambda: np.eye(3))
    motors_first: bool = False

    def raw_mG(self, field_mG: Array, motor_mG: Array, offset_mG: Array | None = None) -> Array:
        """Return R raw = (M s)^-1 (field - k p) - o of fields (n, 3); offsets (n, 3) where o changed on the way."""
        offset = self.offset_mG if offset_mG is None else offset_mG
        before, after = (motor_mG, 0.0) if self.motors_first else (0.0, motor_mG)
        return np.asarray(np.linalg.solve(self.matrix, (field_mG - after).T).T - offset - before)

    def applied(self, parameters: Mapping[str, float]) -> AppliedCalibration:
        """Return the calibration as h = matrix (m - offset), FLU, nT; what the autopilot adds is our offset's minus."""
        turn = np.diag(DOWN)
        offset_nT = -MILLIGAUSS_NT * turn @ self.offset_mG
        return AppliedCalibration(ARDUPILOT, self.compass, offset_nT, turn @ self.matrix @ turn, parameters)


def compass_calibration(parameters: Parameters, compass: int, *, motors_first: bool = False) -> CompassCalibration:
    """Return the calibration that the parameters give; a matrix that is none of a compass counts as not set."""
    own = suffix(compass)
    diagonal, mixed = parameters.vector(f"COMPASS_DIA{own}"), parameters.vector(f"COMPASS_ODI{own}")
    scale = parameters.get(f"COMPASS_SCALE{own}")
    scale = scale if 1 / LARGEST_SCALE <= scale <= LARGEST_SCALE else 1.0
    xy, xz, yz = mixed
    matrix = np.diag(diagonal) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]]) if diagonal.any() else np.eye(3)
    if not is_soft_iron(matrix):
        matrix = np.eye(3)
    return CompassCalibration(compass, parameters.vector(f"COMPASS_OFS{own}"), scale * matrix, motors_first)


def is_soft_iron(matrix: Array) -> bool:
    """Whether a matrix (3, 3) can be undone."""
    return bool(np.linalg.cond(matrix) < WORST_CONDITION)


def compass_of(parameters: Parameters, place: int) -> int:
    """Return the number in the parameters of the compass at a place in the autopilot's order of priority, from 0.

    COMPASS_PRIOk_ID names the device of each place, COMPASS_DEV_IDk the device of each set of parameters.
    """
    device = parameters.get(f"COMPASS_PRIO{place + 1}_ID")
    same = [k for k in COMPASSES if device and parameters.get(f"COMPASS_DEV_ID{suffix(k)}") == device]
    return same[0] if same else place + 1
