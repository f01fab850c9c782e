"""The calibration that PX4 applies to a magnetometer, and its inverse: gauss, forward, right, down (FRD).

Since v1.12 the sensors module applies all of the calibration to the raw field x of the sensor,

    body = R S ((x + P c) - o) - b,

before, the driver applied scale and offset, and the sensors module the rest: body = R (S (x - o) + P c)
[PX4: Magnetometer.hpp, VehicleMagnetometer.cpp].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from recordings.readers.px4.parameters import ParameterState
from recordings.readers.rotations import PX4, ROTATIONS, board_rotation, euler_rotation
from scenarios.arrays import Array

IGNORED = 0.01
"""PX4 ignores a new offset (G), scale or off-diagonal vector whose difference from the one in force is no longer."""
IGNORED_BEFORE = 0.001
"""IGNORED of v1.12."""
UNLEVELLED_RELEASE = (1, 12)
LARGEST_CONDITION = 1e6
"""A scale matrix beyond this condition is damage: no field comes back from what it does."""
PAIRS = (np.array([0, 0, 1]), np.array([1, 2, 2]))
"""Row and column of X, Y, ZODIAG."""
CUSTOM_ROTATION = 100
INTERNAL_BUSES = (2, 4)
"""Bus types in a device's number, SPI and simulation, of sensors on the board."""


class Formula(StrEnum):
    """How a release of PX4 applies the parameters."""

    SENSORS_MODULE = "in the sensors module"
    """body = R S ((x + P c) - o) - b, sensor_mag raw."""
    UNLEVELLED = "in the sensors module, external sensors not levelled"
    """As SENSORS_MODULE, without SENS_BOARD_*_OFF in the R of external sensors: PX4 v1.12."""
    DRIVER = "in the driver"
    """body = R (S (x - o) + P c), sensor_mag = S (x - o): PX4 v1.11 and before."""


@dataclass(frozen=True, eq=False)
class Correction:
    """The parameters of one magnetometer in force for a time.

    Parameters
    ----------
    offset_G : o (3,). scale : S (3, 3), symmetric. rotation : R (3, 3), body = R sensor.
    power : P (3,), gauss by unit of the power signal c (throttle, or kA). power_type : CAL_MAG_COMP_TYP.
    """

    offset_G: Array = field(default_factory=lambda: np.zeros(3))
    scale: Array = field(default_factory=lambda: np.eye(3))
    rotation: Array = field(default_factory=lambda: np.eye(3))
    power: Array = field(default_factory=lambda: np.zeros(3))
    power_type: int = 0

    def body(self, sensor_mag_G: Array, c: Array, bias_G: Array, formula: Formula) -> Array:
        """Return the field (n, 3) that PX4 makes of sensor_mag (n, 3), with the power signal c (n,) and the bias b."""
        power_G = c[:, None] * self.power
        if formula is Formula.DRIVER:
            return np.asarray((sensor_mag_G + power_G) @ self.rotation.T)
        return np.asarray((sensor_mag_G + power_G - self.offset_G) @ (self.rotation @ self.scale).T - bias_G)

    def raw(self, body_G: Array, c: Array, bias_G: Array, formula: Formula) -> Array:
        """Return R x (n, 3), the raw field along the body's axes, of the field `body` (n, 3)."""
        power_G = c[:, None] * self.power
        if formula is Formula.DRIVER:
            return self.raw_of_driver(body_G @ self.rotation - power_G)
        sensor_G = (body_G + bias_G) @ self.rotation @ np.linalg.inv(self.scale).T + self.offset_G - power_G
        return np.asarray(sensor_G @ self.rotation.T)

    def raw_of_driver(self, sensor_mag_G: Array) -> Array:
        """Return R x (n, 3) of a sensor_mag that the driver has calibrated: x = S^-1 sensor_mag + o."""
        return np.asarray((sensor_mag_G @ np.linalg.inv(self.scale).T + self.offset_G) @ self.rotation.T)

    def equals(self, other: Correction) -> bool:
        """Return whether both do the same to a field."""
        return all(np.array_equal(value, getattr(other, name)) for name, value in vars(self).items())

    @property
    def says_nothing(self) -> bool:
        """Whether offset, scale and power compensation are PX4's defaults."""
        return not (
            np.any(self.offset_G) or np.any(self.scale != np.eye(3)) or (self.power_type and np.any(self.power))
        )


def corrections(
    states: Sequence[ParameterState], slots: Sequence[int | None], device: int, formula: Formula
) -> list[Correction]:
    """Return the correction of a magnetometer in each state of the parameters; the same object where nothing changed.

    slots : n of CAL_MAGn_* in each state, None for a sensor without parameters. device : the sensor's number.
    Changes of at most IGNORED are left out as PX4 leaves them out; the drivers of v1.11 and before took every change.
    """
    found: list[Correction] = []
    for state, slot in zip(states, slots, strict=True):
        before = found[-1] if found else Correction()
        after = _updated(before, state, slot, device, formula)
        found.append(before if before.equals(after) else after)
    return found


def slot_of(state: ParameterState, device: int) -> int | None:
    """Return n of the parameters CAL_MAGn_* of a device, None where no CAL_MAGn_ID is the device's number."""
    numbers = (n for n in range(10) if state.whole(f"CAL_MAG{n}_ID") == device)
    return next(numbers, None) if device else None


def formula_by_parameters(state: ParameterState, release: str = "", *, oldest: bool = False) -> Formula:
    """Return the formula of the release that has these parameters: CAL_MAGn_PRIO came, and _EN went, with v1.12.

    release : as the log tells, "1.12.3", "" where it does not. oldest : whether sensor_combined holds the field.
    """
    present = {name.partition("_")[2].partition("_")[2] for name in state.values if name.startswith("CAL_MAG")}
    numbers = tuple(int(part) for part in release.split(".")[:2] if part.isdecimal())
    if "EN" in present or oldest:
        return Formula.DRIVER
    if numbers == UNLEVELLED_RELEASE:
        return Formula.UNLEVELLED
    if present & {"PRIO", "XODIAG"}:
        return Formula.SENSORS_MODULE
    return Formula.DRIVER if len(numbers) == 2 and (0, 0) < numbers < UNLEVELLED_RELEASE else Formula.SENSORS_MODULE


def _updated(before: Correction, state: ParameterState, slot: int | None, device: int, formula: Formula) -> Correction:
    """Return the correction after a change of parameters."""
    rotation = rotation_of(state, slot, device, formula)
    if slot is None:
        return replace(before, rotation=rotation)
    name = f"CAL_MAG{slot}_{{}}"
    least = {Formula.DRIVER: 0.0, Formula.UNLEVELLED: IGNORED_BEFORE}.get(formula, IGNORED)
    return Correction(
        _taken(state.vector(name + "OFF"), before.offset_G, least),
        _scale(before.scale, state.vector(name + "SCALE", 1.0), state.vector(name + "ODIAG"), least),
        rotation,
        state.vector(name + "COMP"),
        state.whole("CAL_MAG_COMP_TYP"),
    )


def _scale(before: Array, diagonal: Array, off_diagonal: Array, least: float) -> Array:
    """Return S (3, 3) after a change; S before where PX4 refuses the new one, or where it has no inverse."""
    taken = _taken(diagonal, np.diag(before), least) if np.all(diagonal > 0) else np.diag(before)
    scale = np.diag(taken)
    scale[PAIRS] = _taken(off_diagonal, before[PAIRS], least)
    scale[PAIRS[::-1]] = scale[PAIRS]
    return scale if np.linalg.cond(scale) < LARGEST_CONDITION else before


def _taken(new: Array, before: Array, least: float) -> Array:
    return new if np.linalg.norm(new - before) > least else before


def rotation_of(state: ParameterState, slot: int | None, device: int, formula: Formula) -> Array:
    """Return R (3, 3): SENS_BOARD_ROT for sensors on the board, CAL_MAGn_ROT for others, levelled by SENS_BOARD_*_OFF.

    A sensor without CAL_MAGn_ROT is on the board where its number names a bus of the board.
    """
    level = euler_rotation(*state.vector("SENS_BOARD_{}_OFF"))
    mounting = -1 if device & 7 in INTERNAL_BUSES else 0
    if slot is not None:
        mounting = state.whole(f"CAL_MAG{slot}_ROT", mounting)
    if mounting < 0:
        return np.asarray(level @ _mounting(state.whole("SENS_BOARD_ROT")))
    if mounting == CUSTOM_ROTATION:
        angles = (state.number(f"CAL_MAG{slot}_{angle}") for angle in ("ROLL", "PITCH", "YAW"))
        return np.asarray(level @ euler_rotation(*angles))
    levelled = formula is Formula.SENSORS_MODULE
    return np.asarray(level @ _mounting(mounting) if levelled else _mounting(mounting))


def _mounting(number: int) -> Array:
    """Return the rotation of a mounting, none for a number that PX4 resets."""
    return board_rotation(number, PX4) if number in ROTATIONS[PX4] else np.eye(3)
