"""This project's own files: calibration.json, the C header, and the YAML of a ROS node."""

from __future__ import annotations

import json
import re

import numpy as np

import calib
from calib import Calibration
from recordings.units import UNITS
from scenarios.files import parsed_json
from validation.calibrating.parameter_files.file_format import (
    CalibrationFormat,
    FileScale,
    FileText,
    marked,
    read_back,
)

NT_PER_TESLA = 1e9
WANTED = "give a calibration.json that `magbench calibrate` wrote"


def _json(source: FileText) -> dict[str, Calibration]:
    """Return the calibrations with an estimate, covariances included."""
    data = parsed_json(source.text, source.where, WANTED)
    if isinstance(data, dict) and isinstance(data.get("calibrations"), dict):
        data = data["calibrations"]
    if not isinstance(data, dict) or not data:
        raise source.fail("holds no calibration", WANTED)
    if "matrix" in data:
        data = {str(data.get("name") or "external"): data}
    every = {k: calib.from_json(json.dumps(v), name=k, where=f"{source.where}: {k}") for k, v in data.items()}
    found = {name: one for name, one in every.items() if one.has_estimate}
    if not found:
        raise source.fail("no calibration in it has an estimate", "calibrate again")
    return found


def _c_header(source: FileText) -> dict[str, Calibration]:
    """Return h = MAG_MATRIX (m - MAG_OFFSET_UNIT)."""
    units = set(re.findall(r"\bMAG_OFFSET_([A-Z]+)\[3\]", source.text))
    if len(units) > 1:
        raise source.fail("holds several calibrations", "keep the lines of one of them")
    (unit,) = units
    offset, matrix = source.numbers([f"MAG_OFFSET_{unit}"], 3), source.numbers(["MAG_MATRIX"], 9)
    if offset is None or matrix is None:
        raise source.fail("MAG_OFFSET or MAG_MATRIX is damaged")
    by_upper = {name.upper(): size for name, (size, *_) in UNITS["mag"].items()}
    if unit in by_upper:
        source = FileText(source.text, source.where, FileScale(by_upper[unit]))
        return {"1": source.scaled("c header", offset, matrix.reshape(3, 3))}
    return {"1": read_back("c header", source.unit_nT() * offset, matrix.reshape(3, 3) / source.unit_nT())}


def _ros(source: FileText) -> dict[str, Calibration]:
    """Return h = matrix (m - offset_T)."""
    offset = source.numbers(["offset_T"], 3)
    rows = re.findall(r"^[ \t]*-[ \t]*\[([^\]\n]*)\]", source.text, re.MULTILINE)
    cells = [[source.number("matrix", cell.strip()) for cell in row.split(",")] for row in rows]
    if offset is None or [len(row) for row in cells] != [3, 3, 3]:
        raise source.fail("offset_T or matrix is damaged")
    return {"1": read_back("ros", NT_PER_TESLA * offset, np.array(cells))}


JSON = CalibrationFormat("calibration.json", lambda text: text.lstrip().startswith("{"), _json)
C_HEADER = CalibrationFormat("C header", marked(r"\bMAG_OFFSET_[A-Z]+\[3\]"), _c_header)
ROS = CalibrationFormat("ROS YAML", marked(r"^[ \t]*offset_T:"), _ros)
