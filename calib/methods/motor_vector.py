"""Offset, matrix and terms of motor currents, commands and temperature, from attitude and field vector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.with_inputs import CalibratorWithInputs


@dataclass(frozen=True)
class MotorVector(CalibratorWithInputs):
    """Offset, S (nine entries), B and the fields of inputs by linear least squares, h known: h = R_wb^T F.

    min sum |m_i - S h_i - b - sum_j k_j p_ij - B dh_i/dt|^2

    Each input is used where legs of the recording that no fit has seen are predicted better with it, as by
    `motor_ellipsoid`. A current's field is seen in every attitude, so a straight flight with changes of thrust tells
    the gains.
    """

    name: ClassVar[str] = "motor_vector"
    summary: ClassVar[str] = "12 linear parameters and the fields of motor currents, throttle, temperature"
    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector", "input")
