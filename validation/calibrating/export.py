"""Export formats of a calibration for flight controllers, firmware and ROS."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from scenarios.errors import InputError

FLU_TO_FRD = np.diag([1.0, -1.0, -1.0])
NT_PER_GAUSS = 1e5
SYMMETRIC = 1e-3
"""Largest |M - M^T| of a matrix that a six-number format accepts; the antisymmetric half is dropped."""


def c_header(calibration: Calibration) -> str:
    """C header: h = MAG_MATRIX (m - MAG_OFFSET_NT), body frame forward-left-up, nT."""
    rows = ",\n".join("    {" + ", ".join(f"{v:.9e}f" for v in row) + "}" for row in calibration.matrix)
    offset = ", ".join(f"{v:.6f}f" for v in calibration.offset_nT)
    return (
        f"/* {calibration.name}: h = MAG_MATRIX (m - MAG_OFFSET_NT), nT; x forward, y left, z up. */\n"
        "#ifndef MAG_CALIBRATION_H\n#define MAG_CALIBRATION_H\n\n"
        f"static const float MAG_OFFSET_NT[3] = {{{offset}}};\n"
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
    return "".join(f"param set {name} {value:.8f}\n" for name, value in values.items())


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
    return "".join(f"{name},{value:.6f}\n" for name, value in values.items())


def ros_yaml(calibration: Calibration) -> str:
    """YAML for a ROS node: h = matrix (m - offset), tesla, forward-left-up (REP-103)."""
    rows = "".join("    - [" + ", ".join(f"{v:.9g}" for v in row) + "]\n" for row in calibration.matrix)
    offset = ", ".join(f"{1e-9 * v:.9g}" for v in calibration.offset_nT)
    return f"magnetometer_calibration:\n  offset_T: [{offset}]\n  matrix:\n{rows}"


FORMATS: dict[str, tuple[str, Callable[[Calibration], str]]] = {
    "c": ("mag_calibration.h", c_header),
    "px4": ("px4.params", px4),
    "ardupilot": ("ardupilot.param", ardupilot),
    "ros": ("magnetometer.yaml", ros_yaml),
}
"""Export formats by name: file name and function that writes the text."""


def known_forms(text: str) -> tuple[str, ...]:
    """Parse a comma-separated list of formats; InputError for a name that is not in FORMATS."""
    forms = tuple(form.strip() for form in text.split(","))
    for form in forms:
        if form not in FORMATS:
            raise InputError(f"no export form {form!r}", where="--export", do=f"choose among {', '.join(FORMATS)}")
    return forms


def exported(calibration: Calibration, form: str) -> tuple[str, str]:
    """Return file name and text of a calibration in a format of FORMATS.

    Raises InputError for a calibration without an estimate, and for a matrix that the format cannot hold.
    """
    if calibration.status.kind in ("not_applicable", "not_converged"):
        why = f"{calibration.name} gave no calibration: {calibration.status.reason}"
        raise InputError(why, where="--export", do="leave it out")
    name, write = FORMATS[form]
    return name, write(calibration)


def _frd_symmetric(calibration: Calibration) -> tuple[Array, Array]:
    """Return offset (3,) and symmetric matrix (3, 3) in forward-right-down axes.

    Raises InputError for a matrix with a rotation, which six numbers cannot hold.
    """
    matrix = FLU_TO_FRD @ calibration.matrix @ FLU_TO_FRD
    if np.abs(matrix - matrix.T).max() > SYMMETRIC:
        what = f"the matrix of {calibration.name} is not symmetric (it turns the sensor)"
        raise InputError(
            what, where="--export", do="export as c or ros, or calibrate without attitude, as by ellipsoid"
        )
    return FLU_TO_FRD @ calibration.offset_nT, 0.5 * (matrix + matrix.T)
