"""Export formats of a calibration for flight controllers, firmware and ROS."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from calib import Calibration
from recordings.applied import AppliedCalibration
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.calibrating.autopilot_parameters import (
    AutopilotParameters,
    ardupilot_parameters,
    left_out,
    px4_parameters,
    without_eddy,
)
from validation.calibrating.output_unit import NANOTESLA, OutputUnit
from validation.text import figure

REAL32, INT32 = 9, 6
"""MAVLink's types of parameters."""
PARAMETER = re.compile(r"([A-Z][A-Z0-9_]+)[\t,](-?[0-9.]+)(?:\t\d)?$", re.MULTILINE)
"""A parameter's line: name, value, and the type where there is one."""


def c_header(calibration: Calibration, applied: AppliedCalibration | None = None, unit: OutputUnit = NANOTESLA) -> str:
    """C header: h = MAG_MATRIX (m - MAG_OFFSET_NT), body frame forward-left-up, nT or another unit.

    The field of inputs, MAG_INPUT_GAINS_NT times input minus reference, behind the lag, is taken off m first.
    """
    rows = ",\n".join("    {" + _floats(row) + "}" for row in unit.matrix(calibration))
    name = f"MAG_OFFSET_{unit.measured.upper()}"
    of = unit.measured if unit.field == unit.measured else f"h in {unit.field}, m in {unit.measured}"
    offset = ", ".join(f"{v:.6f}f" for v in unit.offset(calibration))
    left = "".join(f"/* {line} */\n" for line in without_eddy(calibration))
    return (
        f"{left}/* {calibration.name}: h = MAG_MATRIX (m - {name}), {of}; x forward, y left, z up. */\n"
        "#ifndef MAG_CALIBRATION_H\n#define MAG_CALIBRATION_H\n\n"
        f"static const float {name}[3] = {{{offset}}};\n"
        f"static const float MAG_MATRIX[3][3] = {{\n{rows}\n}};\n{_c_inputs(calibration, unit)}\n#endif\n"
    )


def _c_inputs(calibration: Calibration, unit: OutputUnit) -> str:
    """Arrays of the terms of inputs; nothing without any."""
    terms = calibration.inputs
    if not terms:
        return ""
    names = ", ".join(term.channel for term in terms).replace("*/", "* /")
    gains = ",\n".join("    {" + _floats(term.gain_nT / np.array(unit.nT)) + "}" for term in terms)
    which = f"MAG_INPUT_GAINS_{unit.measured.upper()}"
    return (
        f"\n/* m -= {which}[i] * (input - MAG_INPUT_REFERENCES[i]), the input behind a first-order lag\n"
        f"   of MAG_INPUT_LAGS_S[i] where above 0; in this order: {names}. */\n"
        f"#define MAG_INPUTS {len(terms)}\n"
        f"static const float {which}[MAG_INPUTS][3] = {{\n{gains}\n}};\n"
        f"static const float MAG_INPUT_REFERENCES[MAG_INPUTS] = {{{_floats([term.reference for term in terms])}}};\n"
        f"static const float MAG_INPUT_LAGS_S[MAG_INPUTS] = {{{_floats([term.lag_s for term in terms])}}};\n"
    )


def _floats(values: Iterable[float]) -> str:
    return ", ".join(f"{v:.9e}f" for v in values)


def px4(calibration: Calibration, applied: AppliedCalibration | None = None) -> str:
    """PX4 parameters as QGroundControl loads them: vehicle, component, name, value and type, separated by tabs.

    applied : the calibration in force when the log was made, see `autopilot_parameters.px4_parameters`.
    """
    found = px4_parameters(calibration, applied)
    floats = [f"1\t1\t{name}\t{value:.8f}\t{REAL32}\n" for name, value in found.floats.items()]
    whole = [f"1\t1\t{name}\t{value}\t{INT32}\n" for name, value in found.whole.items()]
    return _commented(found, "# Vehicle-Id Component-Id Name Value Type\n" + "".join((*whole, *floats)))


def ardupilot(calibration: Calibration, applied: AppliedCalibration | None = None) -> str:
    """ArduPilot parameters as Mission Planner loads them: name, value.

    applied : the calibration in force when the log was made, see `autopilot_parameters.ardupilot_parameters`.
    """
    found = ardupilot_parameters(calibration, applied)
    floats = [f"{name},{value:.8f}\n" for name, value in found.floats.items()]
    return _commented(found, "".join((*floats, *(f"{name},{value}\n" for name, value in found.whole.items()))))


def _commented(found: AutopilotParameters, text: str) -> str:
    return "".join(f"# {note}\n" for note in found.notes) + text


def ros_yaml(calibration: Calibration, applied: AppliedCalibration | None = None) -> str:
    """YAML for a ROS node: h = matrix (m - offset - gain (input - reference)), tesla, forward-left-up (REP-103).

    `magnetic_field_covariance`: of the corrected field for sensor_msgs/MagneticField, row by row, T^2, of the noise of
    a sample and the offset's uncertainty; zeros where neither is known.
    """
    rows = "".join("    - [" + ", ".join(f"{v:.9g}" for v in row) + "]\n" for row in calibration.matrix)
    left = "".join(f"# {line}\n" for line in without_eddy(calibration))
    text = f"{left}magnetometer_calibration:\n  offset_T: [{_teslas(calibration.offset_nT)}]\n  matrix:\n{rows}"
    covariance = ", ".join(f"{1e-18 * v:.6g}" for v in field_covariance_nT2(calibration).flat)
    return text + f"  magnetic_field_covariance: [{covariance}]\n" + _ros_inputs(calibration)


def _ros_inputs(calibration: Calibration) -> str:
    """Terms of inputs as a list; nothing without any."""
    terms = [
        f"    - channel: {json.dumps(term.channel)}\n      gain_T: [{_teslas(term.gain_nT)}]\n"
        f"      reference: {term.reference:.9g}\n      lag_s: {term.lag_s:.9g}\n"
        for term in calibration.inputs
    ]
    return "  inputs:\n" + "".join(terms) if terms else ""


def _teslas(values_nT: Array) -> str:
    return ", ".join(f"{1e-9 * v:.9g}" for v in values_nT)


def field_covariance_nT2(calibration: Calibration) -> Array:
    """Covariance (3, 3) of a corrected sample: A (sigma^2 I + C_b) A^T, sigma the noise, C_b the offset's claim."""
    noise_nT = calibration.parameters.get("noise_std_nT", 0.0)
    claimed = calibration.offset_covariance_nT2
    measured = noise_nT**2 * np.eye(3) + (np.zeros((3, 3)) if claimed is None else claimed)
    return np.asarray(calibration.matrix @ measured @ calibration.matrix.T)


@dataclass(frozen=True)
class ExportFormat:
    """File name, function that writes the text, frame of a comment line, and limits of the parameters.

    limits : word in the parameter's name, lowest and highest value
    lost : a line for each term that the format cannot hold
    """

    file: str
    write: Callable[[Calibration, AppliedCalibration | None], str]
    comment: str = "# {}"
    limits: tuple[tuple[str, float, float], ...] = ()
    lost: Callable[[Calibration], tuple[str, ...]] = lambda calibration: ()

    def beyond_limits(self, text: str) -> str:
        """Return the first parameter of a text outside the limits, in words; "" for none."""
        for name, value in PARAMETER.findall(text):
            for word, low, high in self.limits:
                if word in name and not low <= float(value) <= high:
                    return f"{name} {figure(float(value), 4)} is outside {low:g} to {high:g}"
        return ""


FORMATS = {
    "c": ExportFormat("mag_calibration.h", c_header, comment="/* {} */"),
    "px4": ExportFormat("px4.params", px4, limits=(("SCALE", 0.1, 3.0),), lost=left_out),
    "ardupilot": ExportFormat(
        "ardupilot.param",
        ardupilot,
        limits=(("OFS", -1800.0, 1800.0), ("DIA", 0.2, 5.0), ("ODI", -1.0, 1.0)),
        lost=left_out,
    ),
    "ros": ExportFormat("magnetometer.yaml", ros_yaml),
}
"""Export formats by name. Limits: PX4's of the parameter list; ArduPilot's of its own calibration, with
COMPASS_OFFS_MAX at 1800 mG by default, beyond which the vehicle does not arm."""


def known_forms(text: str) -> tuple[str, ...]:
    """Parse a comma-separated list of formats; InputError for a name that is not in FORMATS."""
    forms = tuple(form.strip() for form in text.split(","))
    for form in forms:
        if form not in FORMATS:
            raise InputError(f"no export form {form!r}", where="--export", do=f"choose among {', '.join(FORMATS)}")
    return forms


def exported(
    calibration: Calibration,
    form: str,
    *,
    force: bool = False,
    unit: OutputUnit | None = None,
    applied: AppliedCalibration | None = None,
) -> tuple[str, str]:
    """Return file name and text of a calibration in a format of FORMATS.

    force : write an estimate whose status is not ok, and parameters outside the limits, below comments with the
    reasons. unit : of the C header; the other formats have their own. applied : what the autopilot had in force when
    the log was made: number, device and mounting of the magnetometer. Raises InputError otherwise; always for a
    calibration without an estimate, for a matrix and for terms of each motor that the format cannot hold.
    """
    status, kind = calibration.status, FORMATS[form]
    if not calibration.has_estimate:
        why = status.reason or "its terms correct the scalar magnetometer, and apply uses them"
        raise InputError(f"there is no estimate ({status.kind}): {why}", where=f"--export {form}", do="leave it out")
    text = c_header(calibration, unit=unit) if form == "c" and unit else kind.write(calibration, applied)
    doubts = [
        f"status {status.kind}: {status.reason}" if status.kind != "ok" else "",
        kind.beyond_limits(text),
        *kind.lost(calibration),
    ]
    found = [" ".join(doubt.split()) for doubt in doubts if doubt]
    if found and not force:
        raise InputError("; ".join(found), where=f"--export {form}", do="--force writes it all the same")
    return kind.file, "".join(kind.comment.format(doubt.replace("*/", "* /")) + "\n" for doubt in found) + text
