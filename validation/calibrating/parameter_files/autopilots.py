"""ParameterLines of PX4 and ArduPilot, as lists, dumps and scripts write them."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from calib import Calibration, Status
from calib.input_terms import CURRENT_SUM, InputTerm
from recordings.body_frame import DOWN
from recordings.channels import THROTTLE
from recordings.readers import rotations
from scenarios.arrays import Array
from validation.calibrating.autopilot_parameters import (
    A_PER_KA,
    CURRENT_TYPE,
    NT_PER_GAUSS,
    NT_PER_MILLIGAUSS,
    SECOND_BATTERY,
    THROTTLE_TYPE,
)
from validation.calibrating.parameter_files.file_format import (
    CalibrationFormat,
    FileText,
    marked,
    symmetric,
    upward,
)

LINE = re.compile(
    r"^[ \t]*(?:[x+*][x+* \t]{1,9})?(?:param\s+set(?:-default)?\s+|\d+\s+\d+\s+)?([A-Z][A-Z0-9_]+)"
    r"(?:[ \t]*\[\d+,\d+\][ \t]*:|\s*[\s,=])\s*([^\s,]+)",
    re.MULTILINE,
)
"""A parameter: `param set NAME V`, `1 1 NAME V TYPE` of QGroundControl, `NAME,V`, `NAME V`, and `x + NAME [1,2] : V` of
`param show`."""
INTERNAL, CUSTOM = -1, 100
"""Numbers of CAL_MAGn_ROT: the flight controller's own mounting, and angles in parameters of their own."""
SCALES = (1.0 / 1.5, 1.5)
"""COMPASS_SCALE that ArduPilot applies; others count as 1."""
COMPASSES = {"1": "", "2": "2", "3": "3"}
"""Infix of ArduPilot's parameters by compass."""


class ParameterLines:
    """ParameterLines of a file by name, read as numbers when they are asked for."""

    def __init__(self, source: FileText, words: str) -> None:
        """Take the lines whose name begins with one of the words; InputError for a name with different values."""
        self.source, self.texts = source, dict[str, str]()
        for name, text in LINE.findall(source.text):
            if name.startswith(tuple(words.split())) and self.texts.setdefault(name, text) != text:
                raise source.fail(f"{name} has several values", "keep the line that holds")

    def get(self, name: str, default: float | None = None) -> float:
        """Return a value; InputError for a name that is missing without a default, and for a damaged value."""
        text = self.texts.get(name)
        if text is None:
            if default is None:
                raise self.source.fail(f"{name} is missing")
            return default
        return self.source.number(name, text)

    def three(self, pattern: str, default: float | None = None) -> Array:
        """Return the values of x, y and z: a pattern with {} for the axis."""
        return np.array([self.get(pattern.format(axis), default) for axis in "XYZ"])


def _px4(source: FileText) -> dict[str, Calibration]:
    """Return body = R S (x - o), S symmetric, gauss, o in sensor axes (FRD), of magnetometers with a device."""
    p = ParameterLines(source, "CAL_MAG SENS_BOARD")
    numbers = sorted({name[7] for name in p.texts if re.fullmatch(r"CAL_MAG\d_[XYZ]OFF", name)})
    used = [n for n in numbers if p.get(f"CAL_MAG{n}_ID", 1.0) != 0]
    if not used:
        raise source.fail("no magnetometer of PX4 is calibrated", "give the parameters with CAL_MAG0_XOFF")
    return {n: _px4_magnetometer(p, n) for n in used}


def _px4_magnetometer(p: ParameterLines, number: str) -> Calibration:
    head = f"CAL_MAG{number}_"
    offset_nT = NT_PER_GAUSS * p.three(head + "{}OFF")
    scale = p.three(head + "{}SCALE", 1.0)
    upper = p.three(head + "{}ODIAG", 0.0)
    turn, caveat = _px4_turn(p, head)
    matrix = symmetric(np.where(scale == 0.0, 1.0, scale), *upper)
    found = upward(f"px4 {number}", offset_nT, matrix, turn, caveat)
    kind = int(p.get("CAL_MAG_COMP_TYP", 0.0))
    per_unit = 1.0 if kind == THROTTLE_TYPE else A_PER_KA
    return _with_power(found, kind, -NT_PER_GAUSS / per_unit * turn @ p.three(head + "{}COMP", 0.0))


def _px4_turn(p: ParameterLines, head: str) -> tuple[Array, str]:
    """Return the mounting, body = R sensor, and what was assumed."""
    if head + "ROT" not in p.texts:
        return np.eye(3), f"{head}ROT is not in the file: the sensor's axes were taken for the body's"
    level = rotations.euler_rotation(*p.three("SENS_BOARD_{}_OFF", 0.0))
    number = int(p.get(head + "ROT"))
    if number == CUSTOM:
        angles = [p.get(head + angle) for angle in ("ROLL", "PITCH", "YAW")]
        return level @ rotations.euler_rotation(*angles), ""
    if number == INTERNAL:
        number = int(p.get("SENS_BOARD_ROT", 0.0))
    try:
        return level @ rotations.board_rotation(number, rotations.PX4), ""
    except ValueError as error:
        raise p.source.fail(str(error)) from None


def _ardupilot(source: FileText) -> dict[str, Calibration]:
    """Return field = M s (raw + o), M symmetric, milligauss, body axes (FRD); a compass without offsets is left out."""
    p = ParameterLines(source, "COMPASS_")
    given = {n: infix for n, infix in COMPASSES.items() if f"COMPASS_OFS{infix}_X" in p.texts}
    found = {n: _ardupilot_compass(p, n, infix) for n, infix in given.items()}
    return {n: one for n, one in found.items() if one.has_estimate and one.offset_nT.any()} or found


def _ardupilot_compass(p: ParameterLines, number: str, infix: str) -> Calibration:
    offset_nT = -NT_PER_MILLIGAUSS * p.three(f"COMPASS_OFS{infix}_{{}}")
    diagonal = p.three(f"COMPASS_DIA{infix}_{{}}", 0.0)
    upper = p.three(f"COMPASS_ODI{infix}_{{}}", 0.0)
    scale = p.get(f"COMPASS_SCALE{infix}", 0.0)
    matrix = symmetric(diagonal, *upper) if diagonal.any() else np.eye(3)
    factor = scale if SCALES[0] <= scale <= SCALES[1] else 1.0
    found = upward(f"ardupilot {number}", offset_nT, factor * matrix, np.eye(3))
    added_nT = NT_PER_MILLIGAUSS * p.three(f"COMPASS_MOT{infix}_{{}}", 0.0)
    kind = int(p.get("COMPASS_MOTCT", 0.0))
    if not (kind and added_nT.any()):
        return _with_power(found, kind, added_nT)
    try:
        gain_nT = np.asarray(-np.linalg.solve(factor * matrix, added_nT), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise p.source.fail("COMPASS_DIA and COMPASS_ODI are a singular matrix") from None
    return _with_power(found, kind, gain_nT)


def _with_power(found: Calibration, kind: int, gain_nT: Array) -> Calibration:
    """Return the calibration with the term of throttle or current; gain_nT (3,) : measured per unit, body (FRD)."""
    if not gain_nT.any():
        return found
    if kind not in (THROTTLE_TYPE, CURRENT_TYPE, SECOND_BATTERY):
        what = "a motor compensation is stored and switched off: its terms are left out"
        return replace(found, status=Status("ok", "; ".join(filter(None, (found.status.reason, what)))))
    channel = THROTTLE if kind == THROTTLE_TYPE else CURRENT_SUM
    return replace(found, inputs=(InputTerm(channel, np.array(DOWN) * gain_nT),))


PX4 = CalibrationFormat("PX4", marked(r"\bCAL_MAG\d_[XYZ]OFF\b"), _px4)
ARDUPILOT = CalibrationFormat("ArduPilot", marked(r"\bCOMPASS_OFS[23]?_X\b"), _ardupilot)
