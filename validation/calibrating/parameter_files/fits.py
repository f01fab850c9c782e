"""Print-outs of MotionCal, Magneto and imu_calib, as their users keep and paste them."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from validation.calibrating.parameter_files.file_format import (
    NUMBER,
    CalibrationFormat,
    FileScale,
    FileText,
    marked,
)

NT_PER_MICROTESLA = 1e3
MOTIONCAL_MARK = r"Magnetic (?:Calibration|Offset|Mapping)|\bmag_softiron(?:_matrix)?\b"
MOTIONCAL_OFFSET = ("Magnetic Offset", "mag_offsets", "mag_hardiron")
MOTIONCAL_MATRIX = ("Magnetic Mapping", "mag_softiron_matrix", "mag_softiron")
MAGNETO_OFFSET = (
    r"[Cc]ombined bias(?: vector)?(?: \(?[bB]\)?)?",
    *(r"M_B", r"[bB]", r"magn_ellipsoid_center", r"(?:MAG_)?HARD_IRON(?:_OFFSET)?", r"(?:mag_)?hard_?iron(?:_bias)?"),
)
MAGNETO_MATRIX = (
    r"[Cc]orrection for combined scale factors,[A-Za-z ,]*(?:\(A\^?-1\))?",
    rf"[Cc]orrection matrix A_?inv(?:, using Hm ?= ?{NUMBER})?",
    *(r"M_Ainv", r"A_?inv", r"A\^-1", r"A", r"magn_ellipsoid_transform"),
    *(r"(?:MAG_)?SOFT_IRON(?:_MATRIX)?", r"(?:mag_)?soft_?iron(?:_matrix)?"),
)
MAGNETO_MARK = (
    r"[Cc]ombined bias|\bM_?B\[3\]|\bA_?inv\b|A\^-1|magn_ellipsoid_center|"
    r"\b(?:MAG_)?HARD_IRON|\b(?:mag_)?hard_?iron_?bias"
)


def _motioncal(source: FileText) -> dict[str, Calibration]:
    """Return h = M (m - V), microtesla [MotionCal]: rows `V M M M`, or offset and mapping each by itself."""
    table = source.numbers([r"Magnetic Calibration:?\s*(?:\([^)]*\))?"], 12)
    if table is not None:
        rows = table.reshape(3, 4)
        offset, matrix = rows[:, 0], rows[:, 1:]
    else:
        offset, matrix = _pair(source, MOTIONCAL_OFFSET, MOTIONCAL_MATRIX)
    known = FileText(source.text, source.where, FileScale(NT_PER_MICROTESLA))
    return {"1": known.scaled("motioncal", offset, matrix)}


def _magneto(source: FileText) -> dict[str, Calibration]:
    """Return h = A^-1 (m - b) in the unit of the data that Magneto was given."""
    return {"1": source.scaled("magneto", *_pair(source, MAGNETO_OFFSET, MAGNETO_MATRIX))}


def _imu_calib(source: FileText) -> dict[str, Calibration]:
    """Return h = SM m - bias, as h = SM (m - SM^-1 bias) [ImuCalib]; the file may be of an accelerometer."""
    bias, matrix = _pair(source, ("bias",), ("SM",))
    try:
        offset = np.asarray(np.linalg.solve(matrix, bias), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise source.fail("SM is singular") from None
    return {"1": source.scaled("imu_calib", offset, matrix)}


def _pair(source: FileText, of_offset: tuple[str, ...], of_matrix: tuple[str, ...]) -> tuple[Array, Array]:
    """Return offset (3,) and matrix (3, 3); InputError where one of them is missing or damaged."""
    offset, matrix = source.numbers(of_offset, 3), source.numbers(of_matrix, 9)
    if offset is None or matrix is None:
        missing = "offset" if offset is None else "matrix"
        raise source.fail(f"the {missing} is missing or damaged")
    return offset, matrix.reshape(3, 3)


MOTIONCAL = CalibrationFormat("MotionCal", marked(MOTIONCAL_MARK), _motioncal)
MAGNETO = CalibrationFormat("Magneto", marked(MAGNETO_MARK), _magneto)
IMU_CALIB = CalibrationFormat("imu_calib", marked(r"^[ \t]*SM[ \t]*:"), _imu_calib)
