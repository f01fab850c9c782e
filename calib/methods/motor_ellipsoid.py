"""Ellipsoid with terms of motor currents, commands and temperature, from the field's strength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.with_inputs import CalibratorWithInputs


@dataclass(frozen=True)
class MotorEllipsoid(CalibratorWithInputs):
    """Offset, symmetric S and the fields of inputs from |h| = F alone.

    min sum (n_i . (m_i - S h_i - b - sum_j k_j p_ij - B dh_i/dt))^2,  |h_i| = F, n the normal of the surface S h + b

    Gauss-Newton on the distances from the ellipsoid, the directions of the best h eliminated. Each input is used where
    legs of the recording that no fit has seen are predicted better with it, by Student's 95 % interval over the legs,
    and better than by signals of its spectrum. The gains follow from the strength since the vehicle turns: a current's
    field is seen along the Earth's. S is symmetric, B without the trace, since the strength tells no more.
    """

    name: ClassVar[str] = "motor_ellipsoid"
    summary: ClassVar[str] = "ellipsoid with the fields of motor currents, throttle, temperature; no attitude"
    needs: ClassVar[tuple[str, ...]] = ("input",)
