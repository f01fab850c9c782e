"""Calibrations of autopilots, other programs and earlier exports, read back in: one line a format in FORMATS."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from calib import Calibration
from calib.external import checked
from scenarios.errors import InputError
from scenarios.files import read_text
from validation.calibrating.calibration_file import first_ok
from validation.calibrating.parameter_files.autopilots import ARDUPILOT, PX4
from validation.calibrating.parameter_files.command_lines import BETAFLIGHT, INAV
from validation.calibrating.parameter_files.exports import C_HEADER, JSON, ROS
from validation.calibrating.parameter_files.file_format import CalibrationFormat, FileScale, FileText
from validation.calibrating.parameter_files.fits import IMU_CALIB, MAGNETO, MOTIONCAL

FORMATS: tuple[CalibrationFormat, ...] = (
    JSON,
    PX4,
    ARDUPILOT,
    BETAFLIGHT,
    INAV,
    MOTIONCAL,
    MAGNETO,
    IMU_CALIB,
    C_HEADER,
    ROS,
)
"""Formats of calibrations, recognised by their content."""
LARGEST_CHARACTERS = 1_000_000
"""Longest text; a dump of all parameters has some 60,000 characters."""


def read_parameter_file(path: Path, scale: FileScale | None = None) -> dict[str, Calibration]:
    """Return the calibrations of a file by compass, h = matrix (m - offset_nT) in the body frame (FLU), nT.

    scale : unit of a file that tells none, and length of its corrected field. Raises InputError for a file of no
    format or of several, damaged numbers, and a missing unit.
    """
    text = read_text(path, _wanted(), "utf-8-sig")
    if len(text) > LARGEST_CHARACTERS:
        raise InputError("is too long for a calibration", where=str(path), do=_wanted())
    return calibrations_of(text, str(path), scale or FileScale())


def calibrations_of(text: str, where: str, scale: FileScale) -> dict[str, Calibration]:
    """Return the calibrations of a text by compass; see `read_parameter_file`."""
    source = FileText(text, where, scale)
    fitting = [one for one in FORMATS if one.marks(text)]
    if not fitting:
        raise InputError("holds no calibration of a known format", where=where, do=_wanted())
    if len(fitting) > 1:
        names = " and ".join(one.name for one in fitting)
        raise InputError(f"holds calibrations of {names}", where=where, do="keep the lines of one of them")
    found = fitting[0].read(source)
    return {name: checked(one, f"{where}: {name}", "use another file") for name, one in found.items()}


def chosen(calibrations: dict[str, Calibration], name: str | None, where: str, likely: Sequence[str] = ()) -> str:
    """Return the name of one calibration: as stated, the first of `likely` that is there, else the first that is ok.

    Raises InputError for an unknown name.
    """
    if name is None:
        return next((one for one in likely if one in calibrations), first_ok(calibrations))
    if name not in calibrations:
        do = f"choose among {', '.join(calibrations)}"
        raise InputError(f"no calibration {name!r}", where=where, do=do)
    return name


def _wanted() -> str:
    return "give a calibration.json, or a calibration of " + ", ".join(one.name for one in FORMATS[1:])
