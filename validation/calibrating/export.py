"""Export formats of a calibration for flight controllers, firmware and ROS."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.calibrating.output_unit import NANOTESLA, OutputUnit

FLU_TO_FRD = np.diag([1.0, -1.0, -1.0])
NT_PER_GAUSS = 1e5
SYMMETRIC = 1e-3
"""Largest |M - M^T| of a matrix that a six-number format accepts; the antisymmetric half is dropped."""
OF_Z = ("ZOFF", "ZSCALE", "YODIAG", "ZODIAG", "OFS_Z", "DIA_Z", "ODI_Y", "ODI_Z")
"""Ends of the parameters of z, and of the matrix's entries xz and yz."""
PARAMETER = re.compile(r"([A-Z][A-Z0-9_]+)[ ,](-?[0-9.]+)$", re.MULTILINE)
"""A parameter's line: name, and value after a blank or a comma."""


def c_header(calibration: Calibration, unit: OutputUnit = NANOTESLA) -> str:
    """C header: h = MAG_MATRIX (m - MAG_OFFSET_NT), body frame forward-left-up, nT or another unit."""
    rows = ",\n".join("    {" + ", ".join(f"{v:.9e}f" for v in row) + "}" for row in unit.matrix(calibration))
    offset = ", ".join(f"{v:.6f}f" for v in unit.offset(calibration))
    name = f"MAG_OFFSET_{unit.measured.upper()}"
    of = unit.measured if unit.field == unit.measured else f"h in {unit.field}, m in {unit.measured}"
    return (
        f"/* {calibration.name}: h = MAG_MATRIX (m - {name}), {of}; x forward, y left, z up. */\n"
        "#ifndef MAG_CALIBRATION_H\n#define MAG_CALIBRATION_H\n\n"
        f"static const float {name}[3] = {{{offset}}};\n"
        f"static const float MAG_MATRIX[3][3] = {{\n{rows}\n}};\n\n#endif\n"
    )


def px4(calibration: Calibration) -> str:
    """PX4 parameters of magnetometer 0: scale (m - offset), gauss, forward-right-down, symmetric scale matrix.

    PX4 applies the parameters in sensor axes, before CAL_MAG0_ROT, to the sensor of device number CAL_MAG0_ID.
    """
    offset, matrix = _frd_symmetric(calibration)
    upper = (matrix[0, 1], matrix[0, 2], matrix[1, 2])
    values = {f"CAL_MAG0_{axis}OFF": v / NT_PER_GAUSS for axis, v in zip("XYZ", offset, strict=True)}
    values |= {f"CAL_MAG0_{axis}SCALE": v for axis, v in zip("XYZ", np.diag(matrix), strict=True)}
    values |= {f"CAL_MAG0_{axis}ODIAG": v for axis, v in zip("XYZ", upper, strict=True)}
    return "".join(f"param set {name} {value:.8f}\n" for name, value in _estimated(values, calibration))


def ardupilot(calibration: Calibration) -> str:
    """ArduPilot parameters of compass 1: matrix SCALE (m + OFS), milligauss, forward-right-down, symmetric matrix.

    ArduPilot applies the parameters in body axes; the matrix includes the scale, so COMPASS_SCALE is reset to 1.
    """
    offset, matrix = _frd_symmetric(calibration)
    upper = (matrix[0, 1], matrix[0, 2], matrix[1, 2])
    values = {f"COMPASS_OFS_{axis}": -1e3 * v / NT_PER_GAUSS for axis, v in zip("XYZ", offset, strict=True)}
    values |= {f"COMPASS_DIA_{axis}": v for axis, v in zip("XYZ", np.diag(matrix), strict=True)}
    values |= {f"COMPASS_ODI_{axis}": v for axis, v in zip("XYZ", upper, strict=True)}
    values["COMPASS_SCALE"] = 1.0
    return "".join(f"{name},{value:.6f}\n" for name, value in _estimated(values, calibration))


def _estimated(values: dict[str, float], calibration: Calibration) -> list[tuple[str, float]]:
    """Return the parameters that are estimated: a planar calibration leaves those of z as the vehicle has them."""
    skipped = () if calibration.determines_z else OF_Z
    return [(name, value) for name, value in values.items() if not name.endswith(skipped)]


def ros_yaml(calibration: Calibration) -> str:
    """YAML for a ROS node: h = matrix (m - offset), tesla, forward-left-up (REP-103)."""
    rows = "".join("    - [" + ", ".join(f"{v:.9g}" for v in row) + "]\n" for row in calibration.matrix)
    offset = ", ".join(f"{1e-9 * v:.9g}" for v in calibration.offset_nT)
    return f"magnetometer_calibration:\n  offset_T: [{offset}]\n  matrix:\n{rows}"


@dataclass(frozen=True)
class ExportFormat:
    """File name, function that writes the text, frame of a comment line, and limits of the parameters.

    limits : word in the parameter's name, lowest and highest value
    """

    file: str
    write: Callable[[Calibration], str]
    comment: str = "# {}"
    limits: tuple[tuple[str, float, float], ...] = ()

    def beyond_limits(self, text: str) -> str:
        """Return the first parameter of a text outside the limits, in words; "" for none."""
        for name, value in PARAMETER.findall(text):
            for word, low, high in self.limits:
                if word in name and not low <= float(value) <= high:
                    return f"{name} {float(value):.4g} is outside {low:g} to {high:g}"
        return ""


FORMATS = {
    "c": ExportFormat("mag_calibration.h", c_header, comment="/* {} */"),
    "px4": ExportFormat("px4.params", px4, limits=(("SCALE", 0.1, 3.0),)),
    "ardupilot": ExportFormat(
        "ardupilot.param", ardupilot, limits=(("OFS", -1800.0, 1800.0), ("DIA", 0.2, 5.0), ("ODI", -1.0, 1.0))
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
    calibration: Calibration, form: str, *, force: bool = False, unit: OutputUnit | None = None
) -> tuple[str, str]:
    """Return file name and text of a calibration in a format of FORMATS.

    force : write an estimate whose status is not ok, and parameters outside the limits, below comments with the
    reasons. unit : of the C header; the other formats have their own. Raises InputError otherwise; always for a
    calibration without an estimate, and for a matrix that the format cannot hold.
    """
    status, kind = calibration.status, FORMATS[form]
    if not calibration.has_estimate:
        why = status.reason or "its terms correct the scalar magnetometer, and apply uses them"
        raise InputError(f"there is no estimate ({status.kind}): {why}", where=f"--export {form}", do="leave it out")
    text = c_header(calibration, unit) if form == "c" and unit else kind.write(calibration)
    doubts = [
        f"status {status.kind}: {status.reason}" if status.kind != "ok" else "",
        kind.beyond_limits(text),
    ]
    found = [" ".join(doubt.split()) for doubt in doubts if doubt]
    if found and not force:
        raise InputError("; ".join(found), where=f"--export {form}", do="--force writes it all the same")
    return kind.file, "".join(kind.comment.format(doubt.replace("*/", "* /")) + "\n" for doubt in found) + text


def _frd_symmetric(calibration: Calibration) -> tuple[Array, Array]:
    """Return offset (3,) and symmetric matrix (3, 3) in forward-right-down axes.

    Raises InputError for a matrix with a rotation, which six numbers cannot hold.
    """
    matrix = FLU_TO_FRD @ calibration.matrix @ FLU_TO_FRD
    if np.abs(matrix - matrix.T).max() > SYMMETRIC:
        what = "the matrix is not symmetric (it turns the sensor)"
        raise InputError(
            what, where="--export", do="export as c or ros, or calibrate without attitude, as by ellipsoid"
        )
    return FLU_TO_FRD @ calibration.offset_nT, 0.5 * (matrix + matrix.T)
