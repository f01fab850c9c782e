"""A calibration as parameters of ArduPilot and PX4, joined with those in force when the log was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from calib import Calibration
from calib.input_terms import CURRENT_SUM, InputTerm
from calib.models.inputs import BATTERY
from recordings.applied import AppliedCalibration
from recordings.channels import TEMPERATURE, THROTTLE, current_name
from recordings.readers.rotations import CUSTOM, PX4, board_rotation, euler_rotation
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.text import figure

FLU_TO_FRD = np.diag([1.0, -1.0, -1.0])
NT_PER_GAUSS, NT_PER_MILLIGAUSS, A_PER_KA = 1e5, 1e2, 1e3
SYMMETRIC = 1e-3
"""Largest |M - M^T| of a matrix that a six-number format accepts; the antisymmetric half is dropped."""
OF_Z = ("ZOFF", "ZSCALE", "YODIAG", "ZODIAG", "OFS_Z", "DIA_Z", "ODI_Y", "ODI_Z")
"""Ends of the parameters of z, and of the matrix's entries xz and yz, without a compass's number."""
UPRIGHT = 1 - 1e-6
"""|R_zz| from which a mounting keeps the vehicle's z on the sensor's z."""
IGNORED = 0.01
"""Change of the offset, gauss, and of scales, that PX4 ignores [PX4: sensor_calibration/Magnetometer.cpp]."""
THROTTLE_TYPE, CURRENT_TYPE, SECOND_BATTERY = 1, 2, 3
"""COMPASS_MOTCT, and CAL_MAG_COMP_TYP: by throttle, by battery current, by the current of battery 1."""


@dataclass(frozen=True)
class AutopilotParameters:
    """Values by name, those of whole numbers, and lines for the user."""

    floats: Mapping[str, float]
    whole: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def joined(self, more: AutopilotParameters) -> AutopilotParameters:
        """Return these parameters and more."""
        return AutopilotParameters(
            {**self.floats, **more.floats}, {**self.whole, **more.whole}, (*self.notes, *more.notes)
        )


@dataclass(frozen=True, eq=False)
class PowerTerm:
    """Field per unit of throttle (0 to 1) or per ampere, nT, body frame (FLU), measured: m = S h + b + k p."""

    kind: int
    gain_nT: Array


def power_term(calibration: Calibration) -> PowerTerm | None:
    """Return the one term of throttle or battery current; None without.

    Raises InputError for terms of each motor, which no parameter holds.
    """
    found = [(_kind(term.channel), term) for term in calibration.inputs]
    power = [(kind, term) for kind, term in found if kind]
    if len(power) > 1 or any(not kind and term.channel != TEMPERATURE for kind, term in found):
        what = "its terms of each motor fit no parameter of an autopilot"
        do = "calibrate with motor_ellipsoid:battery or motor_ellipsoid:throttle, or export as c or ros"
        raise InputError(what, where="--export", do=do)
    return PowerTerm(power[0][0], power[0][1].gain_nT) if power else None


def _kind(channel: str) -> int:
    """Return the type of compensation by a channel; 0 for a channel that is neither throttle nor battery current."""
    if channel == THROTTLE:
        return THROTTLE_TYPE
    if BATTERY.fullmatch(channel):
        return SECOND_BATTERY if "1" in channel else CURRENT_TYPE
    return CURRENT_TYPE if channel in (CURRENT_SUM, current_name(1)) else 0


def left_out(calibration: Calibration) -> tuple[str, ...]:
    """Return what an autopilot's parameters cannot hold, a line each: temperatures and lags of inputs."""
    return tuple(_without(term) for term in calibration.inputs if not _kind(term.channel))


def _without(term: InputTerm) -> str:
    size = float(np.linalg.norm(term.gain_nT))
    return f"the field of {term.channel} ({figure(size)} nT a unit) is left out: the offset holds at {term.reference:g}"


def told(calibration: Calibration) -> tuple[str, ...]:
    """Return notes on what an autopilot computes otherwise than `apply`."""
    lags = [f"the lag of {one.lag_s:g} s behind {one.channel} is left out" for one in calibration.inputs if one.lag_s]
    return (*lags, *without_eddy(calibration))


def without_eddy(calibration: Calibration) -> tuple[str, ...]:
    """Return the line of a format that has no place for the eddy currents' term."""
    return () if calibration.eddy_s is None else ("the eddy currents' term is left out",)


def ardupilot_parameters(calibration: Calibration, applied: AppliedCalibration | None = None) -> AutopilotParameters:
    """Return field = M (raw + OFS) + MOT p, milligauss, forward-right-down, body axes, of the compass of the log.

    OFS = -b,  M = A,  MOT = -A k;  COMPASS_SCALE is 1, since M includes the scale. Without an `applied` of ArduPilot it
    is compass 1. Raises InputError for a matrix with a rotation and for terms of each motor.
    """
    offset, matrix = frd_symmetric(calibration)
    force = _in_force(applied, "ardupilot")
    number = "" if applied is None or not force or applied.compass == 1 else str(applied.compass)
    values = _axes(f"COMPASS_OFS{number}_{{}}", -offset / NT_PER_MILLIGAUSS)
    values |= _axes(f"COMPASS_DIA{number}_{{}}", np.diag(matrix)) | _axes(f"COMPASS_ODI{number}_{{}}", _upper(matrix))
    values[f"COMPASS_SCALE{number}"] = 1.0
    own = _kept((f"COMPASS_DEV_ID{number}", f"COMPASS_ORIENT{number}", f"COMPASS_EXTERN{number}"), force)
    iron = AutopilotParameters(_estimated(values, calibration, number), own, told(calibration))
    return iron.joined(_ardupilot_motors(power_term(calibration), matrix, force, f"COMPASS_MOT{number}_{{}}"))


def _ardupilot_motors(
    power: PowerTerm | None, matrix: Array, force: Mapping[str, float], names: str
) -> AutopilotParameters:
    """Return COMPASS_MOT and its type; MOT of 0 in place of a compensation in force, whose field is in the offset."""
    if power is None:
        return _switched_off(names, force)
    kind = min(power.kind, CURRENT_TYPE)
    gain = -matrix @ FLU_TO_FRD @ power.gain_nT / NT_PER_MILLIGAUSS
    each = {"COMPASS_PMOT_EN": 0} if force.get("COMPASS_PMOT_EN") else {}
    notes = ["COMPASS_PMOT_EN is set to 0: the terms of each motor are replaced"] if each else []
    notes += _changed("COMPASS_MOTCT", kind, force)
    return AutopilotParameters(_axes(names, gain), {"COMPASS_MOTCT": kind, **each}, tuple(notes))


def px4_parameters(calibration: Calibration, applied: AppliedCalibration | None = None) -> AutopilotParameters:
    """Return body = R SCALE ((x + COMP p) - OFF), gauss, sensor axes (FRD), of the magnetometer of the log.

    OFF = R^T b,  SCALE = R^T A R,  COMP = -R^T k (per 1000 A for a battery's current). R is the mounting of the sensor
    by the parameters in force; without an `applied` of PX4 it is magnetometer 0, with the body's axes. Raises
    InputError as `ardupilot_parameters`, and for a mounting that PX4 does not have.
    """
    force = _in_force(applied, PX4)
    head = f"CAL_MAG{applied.compass if applied is not None and force else 0}_"
    turn = px4_mounting(force, head) if head + "ROT" in force else np.eye(3)
    iron = _px4_iron(calibration, force, head, turn)
    return iron.joined(_px4_motors(power_term(calibration), turn, force, head + "{}COMP"))


def _px4_iron(calibration: Calibration, force: Mapping[str, float], head: str, turn: Array) -> AutopilotParameters:
    """Return OFF, SCALE and ODIAG, with device and mounting; turn : R (3, 3), body = R sensor."""
    offset, matrix = frd_symmetric(calibration)
    tilted = not calibration.determines_z and abs(turn[2, 2]) < UPRIGHT
    if tilted:
        offset, matrix = _with_z_in_force(offset, matrix, turn, _px4_in_force(force, head))
    offset, matrix = turn.T @ offset, turn.T @ matrix @ turn
    values = _axes(head + "{}OFF", offset / NT_PER_GAUSS) | _axes(head + "{}SCALE", np.diag(matrix))
    values |= _axes(head + "{}ODIAG", _upper(matrix))
    angles = {head + angle: force[head + angle] for angle in ("ROLL", "PITCH", "YAW") if head + angle in force}
    own, notes = _kept((head + "ID", head + "ROT"), force), [*told(calibration), *_ignored(values, force, head)]
    notes += ["the sensor is tilted: what is along the vehicle's z is as in force, in all parameters"] if tilted else []
    estimated = values if tilted else _estimated(values, calibration)
    return AutopilotParameters(estimated | angles, own, tuple(notes))


def _px4_in_force(force: Mapping[str, float], head: str) -> tuple[Array, Array]:
    """Return OFF, nT, and SCALE (3, 3) in force, sensor axes."""
    offset, diagonal, (xy, xz, yz) = (
        np.array([force.get(f"{head}{axis}{end}", usual) for axis in "XYZ"])
        for end, usual in (("OFF", 0.0), ("SCALE", 1.0), ("ODIAG", 0.0))
    )
    return offset * NT_PER_GAUSS, np.diag(diagonal) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])


def _with_z_in_force(offset: Array, matrix: Array, turn: Array, force: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return offset (3,) and matrix (3, 3), body axes, whose entries of z are those in force.

    turn : R, body = R sensor. force : OFF, nT, and SCALE, sensor axes.
    """
    before_offset, before_matrix = turn @ force[0], turn @ force[1] @ turn.T
    level = np.array([True, True, False])
    return np.where(level, offset, before_offset), np.where(np.outer(level, level), matrix, before_matrix)


def _px4_motors(power: PowerTerm | None, turn: Array, force: Mapping[str, float], names: str) -> AutopilotParameters:
    """Return CAL_MAGn_COMP and its type, or COMP of 0 in place of a compensation in force."""
    if power is None:
        return _switched_off(names, force)
    per_unit = 1.0 if power.kind == THROTTLE_TYPE else A_PER_KA
    gain = -per_unit * turn.T @ FLU_TO_FRD @ power.gain_nT / NT_PER_GAUSS
    notes = tuple(_changed("CAL_MAG_COMP_TYP", power.kind, force))
    return AutopilotParameters(_axes(names, gain), {"CAL_MAG_COMP_TYP": power.kind}, notes)


def _switched_off(names: str, force: Mapping[str, float]) -> AutopilotParameters:
    """Return a motor compensation of 0 in place of one in force; nothing where none is."""
    if not any(force.get(names.format(axis)) for axis in "XYZ"):
        return AutopilotParameters({})
    note = f"{names.format('X')} .. Z are set to 0: the motors' field is in the offset, as in this log"
    return AutopilotParameters(_axes(names, np.zeros(3)), notes=(note,))


def _upper(matrix: Array) -> Array:
    """Return the entries xy, xz, yz."""
    return np.array((matrix[0, 1], matrix[0, 2], matrix[1, 2]))


def px4_mounting(force: Mapping[str, float], head: str) -> Array:
    """Return R (3, 3), body = R sensor, of CAL_MAGn_ROT; InputError for a number without a mounting."""
    level = euler_rotation(*(force.get(f"SENS_BOARD_{axis}_OFF", 0.0) for axis in "XYZ"))
    number = int(force[head + "ROT"])
    number = int(force.get("SENS_BOARD_ROT", 0)) if number < 0 else number
    if number in CUSTOM:
        return level @ euler_rotation(*(force.get(head + angle, 0.0) for angle in ("ROLL", "PITCH", "YAW")))
    try:
        return level @ board_rotation(number, PX4)
    except ValueError as error:
        raise InputError(str(error), where="--export px4", do="export as c or ros") from None


def frd_symmetric(calibration: Calibration) -> tuple[Array, Array]:
    """Return offset (3,) at throttle and current 0, and symmetric matrix (3, 3), in forward-right-down axes.

    Raises InputError for a matrix with a rotation, which six numbers cannot hold.
    """
    matrix = FLU_TO_FRD @ calibration.matrix @ FLU_TO_FRD
    if np.abs(matrix - matrix.T).max() > SYMMETRIC:
        what = "the matrix is not symmetric (it turns the sensor)"
        raise InputError(
            what, where="--export", do="export as c or ros, or calibrate without attitude, as by ellipsoid"
        )
    offset_nT = calibration.offset_nT.copy()
    for term in calibration.inputs:
        if _kind(term.channel):
            offset_nT -= term.gain_nT * term.reference
    return FLU_TO_FRD @ offset_nT, 0.5 * (matrix + matrix.T)


def _axes(pattern: str, values: Array) -> dict[str, float]:
    return {pattern.format(axis): float(value) for axis, value in zip("XYZ", values, strict=True)}


def _in_force(applied: AppliedCalibration | None, autopilot: str) -> Mapping[str, float]:
    """Return the parameters in force of this autopilot; empty for a log of another, or of none."""
    return applied.parameters if applied is not None and applied.autopilot == autopilot else {}


def _kept(names: tuple[str, ...], force: Mapping[str, float]) -> dict[str, int]:
    """Return the whole numbers in force under some names."""
    return {name: int(force[name]) for name in names if name in force}


def _changed(name: str, value: int, force: Mapping[str, float]) -> list[str]:
    """Return a note where a parameter that all magnetometers share changes."""
    before = int(force.get(name, 0))
    if before in (0, value):
        return []
    return [f"{name} changes from {before} to {value}, for all magnetometers: measure the others' motor fields again"]


def _ignored(values: Mapping[str, float], force: Mapping[str, float], head: str) -> list[str]:
    """Return notes on changes that PX4 ignores."""
    told = []
    for what, end, usual in (("offset", "OFF", 0.0), ("scales", "SCALE", 1.0), ("off-diagonals", "ODIAG", 0.0)):
        names = [f"{head}{axis}{end}" for axis in "XYZ"]
        change = np.array([values[name] - force.get(name, usual) for name in names])
        if 0.0 < float(np.linalg.norm(change)) <= IGNORED:
            size = f"{np.linalg.norm(change):.2g}" + (" G" if what == "offset" else "")
            told.append(f"PX4 ignores a change of the {what} of {IGNORED:g} or less; this one is {size}")
    return told


def _estimated(values: dict[str, float], calibration: Calibration, number: str = "") -> dict[str, float]:
    """Return the parameters that are estimated: a planar calibration leaves those of z as the vehicle has them."""
    if calibration.determines_z:
        return values
    return {name: value for name, value in values.items() if not name.replace(f"{number}_", "_").endswith(OF_Z)}
