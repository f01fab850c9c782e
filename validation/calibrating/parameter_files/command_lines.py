"""Settings of Betaflight and INAV, as `dump` and `diff` of the command line print them."""

from __future__ import annotations

import re

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from validation.calibrating.parameter_files.file_format import CalibrationFormat, FileText, marked, read_back

SETTING = r"^[ \t]*set[ \t]+{}[ \t]*=[ \t]*(\S.*)$"
UNIT_GAIN = 1024.0
"""INAV's maggain of a gain of 1."""
ALIGNMENTS = {
    "CW0": "x y z",
    "CW90": "y -x z",
    "CW180": "-x -y z",
    "CW270": "-y x z",
    "CW0FLIP": "-x y -z",
    "CW90FLIP": "y x -z",
    "CW180FLIP": "x -y -z",
    "CW270FLIP": "-y -x -z",
}
"""Body axes (FLU) in sensor axes by align_mag [Betaflight: sensors/boardalignment.c]."""


def _setting(source: FileText, name: str) -> str | None:
    """Return the value of a setting; None where it is not set, InputError for several values."""
    found = {text.strip() for text in re.findall(SETTING.format(name), source.text, re.MULTILINE)}
    if len(found) > 1:
        raise source.fail(f"{name} has several values", "keep the line that holds")
    return found.pop() if found else None


def _betaflight(source: FileText) -> dict[str, Calibration]:
    """Return magADC = R raw - magZero, counts, in body axes (FLU)."""
    cells = re.split(r"\s*,\s*|\s+", _setting(source, "mag_calibration") or "")
    if len(cells) != 3:
        raise source.fail("mag_calibration has no three numbers")
    offset = np.array([source.number("mag_calibration", cell) for cell in cells])
    if not offset.any():
        raise source.fail("mag_calibration is 0,0,0: not calibrated", "calibrate, then dump the settings again")
    return {"1": read_back("betaflight", source.unit_nT() * offset, np.eye(3))}


def _inav(source: FileText) -> dict[str, Calibration]:
    """Return m = R ((raw - magzero) 1024 / maggain), counts; R of align_mag."""
    texts = {
        name: _setting(source, f"mag{name}") for name in (f"{kind}_{a}" for kind in ("zero", "gain") for a in "xyz")
    }
    value = {name: source.number(f"mag{name}", text) for name, text in texts.items() if text is not None}
    offset = np.array([value.get(f"zero_{axis}", 0.0) for axis in "xyz"])
    gain = np.array([value.get(f"gain_{axis}", UNIT_GAIN) for axis in "xyz"])
    if (gain == 0).any():
        raise source.fail("maggain is 0: not calibrated", "calibrate, then dump the settings again")
    turn, caveat = _alignment(source)
    found = turn @ np.diag(UNIT_GAIN / gain) @ turn.T
    return {"1": read_back("inav", source.unit_nT() * (turn @ offset), found, caveat)}


def _alignment(source: FileText) -> tuple[Array, str]:
    """Return R (3, 3), body (FLU) = R sensor, and what was assumed."""
    name = _setting(source, "align_mag")
    if name in (None, "DEFAULT"):
        return np.eye(3), "align_mag is not stated: the sensor's axes were taken for the body's"
    if name not in ALIGNMENTS:
        raise source.fail(f"align_mag: {str(name)[:40]!r} is no alignment")
    rows = ALIGNMENTS[str(name)].split()
    axes = {
        word: sign * np.eye(3)[k] for k, axis in enumerate("xyz") for word, sign in ((axis, 1.0), (f"-{axis}", -1.0))
    }
    return np.array([axes[word] for word in rows]), ""


BETAFLIGHT = CalibrationFormat("Betaflight", marked(r"^[ \t]*set[ \t]+mag_calibration[ \t]*="), _betaflight)
INAV = CalibrationFormat("INAV", marked(r"^[ \t]*set[ \t]+magzero_[xyz][ \t]*="), _inav)
