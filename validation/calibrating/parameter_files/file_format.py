"""A file with a calibration: its text, its scale, and how a format recognises and reads it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calib import Calibration, Status
from recordings.body_frame import DOWN
from recordings.units import UNITS
from scenarios.arrays import Array
from scenarios.errors import InputError

UNIT_OPTION, NORM_OPTION = "--old-unit", "--old-norm"
NUMBER = r"[-+]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][-+]?\d{1,4})?"
BETWEEN = r"(?:[\s,;:\[\]{}()|]|-(?=\s)){0,99}"
"""What stands between the numbers of a vector or matrix, in C, Python, YAML and print-outs."""
LARGEST = 1e30
"""Largest number of a file: products of units, offsets and matrices stay finite."""
COMMENTS = re.compile(r"/\*.*?(?:\*/|\Z)|//[^\n]*|#[^\n]*", re.DOTALL)
GAINS = (0.2, 5.0)
"""Mean gain of a matrix between equal units: ArduPilot's limits of COMPASS_DIA."""


@dataclass(frozen=True)
class FileScale:
    """Unit and length of the field of a file that tells neither.

    nT : size of the file's unit; None: unknown. norm : length of the corrected field in that unit, where the file's
    matrix leads to another unit, as 1 for a unit sphere. strength_nT : of the Earth's field.
    """

    nT: float | None = None
    norm: float | None = None
    strength_nT: float | None = None

    @classmethod
    def stated(cls, unit: str | None, norm: float | None = None, strength_nT: float | None = None) -> FileScale:
        """Return the scale of --old-unit: a unit of the field, or `counts=NT_A_COUNT`; InputError for other words."""
        if norm is not None and not (np.isfinite(norm) and norm > 0):
            raise InputError(f"{norm} is no length of a field", where=NORM_OPTION, do="give a positive number")
        if unit is None or unit in UNITS["mag"]:
            return cls(None if unit is None else UNITS["mag"][unit][0], norm, strength_nT)
        size = re.fullmatch(rf"counts?=({NUMBER})", unit)
        if size is None or not 0 < float(size[1]) <= LARGEST:
            known = ", ".join((*UNITS["mag"], "counts=NT_A_COUNT"))
            raise InputError(f"{unit!r} is no unit", where=UNIT_OPTION, do=f"choose among {known}")
        return cls(float(size[1]), norm, strength_nT)


@dataclass(frozen=True)
class FileText:
    """The text of a file, its name for messages, and the scale that the user states."""

    text: str
    where: str
    scale: FileScale

    def fail(self, what: str, do: str = "give the whole file as it was written") -> InputError:
        """Return the error of a defect in the file."""
        return InputError(what, where=self.where, do=do)

    def number(self, name: str, text: str) -> float:
        """Return a parameter's value; InputError for anything but a number up to LARGEST."""
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not abs(value) <= LARGEST:
            raise self.fail(f"{name}: {text[:40]!r} is not a number up to {LARGEST:g}")
        return value

    def unit_nT(self) -> float:
        """Return the size of the file's unit, nT; InputError where it is not stated."""
        if self.scale.nT is None:
            raise self.fail("tells no unit of the offset", f"state it: {UNIT_OPTION} uT, or counts=NT_A_COUNT")
        return self.scale.nT

    def scaled(self, name: str, offset: Array, matrix: Array) -> Calibration:
        """Return the calibration of offset and matrix in the file's unit.

        With a stated length of the corrected field, matrix F / (norm nT). Raises InputError for an unknown unit, and
        for a matrix that leads to another unit of unknown size.
        """
        nT = self.unit_nT()
        if self.scale.norm is not None:
            if self.scale.strength_nT is None:
                raise self.fail("needs the field's strength beside its length", "give --field-strength-nT F")
            matrix = matrix * self.scale.strength_nT / (self.scale.norm * nT)
        gain = float(np.cbrt(abs(np.linalg.det(matrix))))
        if not GAINS[0] <= gain <= GAINS[1]:
            do = f"state the length of its corrected field: {NORM_OPTION} N"
            raise self.fail(f"the matrix scales by {gain:.3g}: it does not lead to the unit of the offset", do)
        return read_back(name, nT * offset, matrix)

    def numbers(self, labels: Sequence[str], count: int) -> Array | None:
        """Return the `count` numbers after one of the labels (regular expressions), comments left out; None for none.

        Raises InputError where different numbers follow.
        """
        text = COMMENTS.sub("", self.text)
        label = rf"(?<![\w.])(?:{'|'.join(labels)})"
        head = label + r"(?:\[\d\]){0,2}\s{0,9}[=:]?\s{0,9}(?:np\.array|numpy\.array|float3x3|float3)?"
        found = re.findall(head + "((?:" + BETWEEN + NUMBER + rf"[fF]?(?![\w.])){{{count}}})", text)
        values = [np.array([float(v) for v in re.findall(NUMBER, block)]) for block in found]
        if not values:
            return None
        if any(not np.array_equal(values[0], other) for other in values[1:]):
            raise self.fail("holds several calibrations", "keep the lines of one of them")
        if not (np.abs(values[0]) <= LARGEST).all():
            raise self.fail(f"holds numbers beyond {LARGEST:g}")
        return values[0]


@dataclass(frozen=True)
class CalibrationFormat:
    """A format: its name, the mark by which a text is recognised, and the calibrations in a text by compass."""

    name: str
    marks: Callable[[str], bool]
    read: Callable[[FileText], dict[str, Calibration]]


def marked(pattern: str) -> Callable[[str], bool]:
    """Return the test whether a text matches a pattern, at the beginning of lines too."""
    found = re.compile(pattern, re.MULTILINE)
    return lambda text: found.search(text) is not None


def read_back(name: str, offset_nT: Array, matrix: Array, caveat: str = "") -> Calibration:
    """Return a calibration that was read: without covariance, for no file tells one."""
    return Calibration(name=name, status=Status("ok", caveat), offset_nT=offset_nT, matrix=matrix)


def upward(name: str, offset_nT: Array, matrix: Array, turn: Array, caveat: str = "") -> Calibration:
    """Return the calibration in FLU of offset and matrix in a sensor's axes, body (FRD) = turn sensor.

    b = D R o,  A = D R M R^T D,  D = diag(1, -1, -1)
    """
    to_flu = np.diag(DOWN) @ turn
    return read_back(name, to_flu @ offset_nT, to_flu @ matrix @ to_flu.T, caveat)


def symmetric(diagonal: Array, xy: float, xz: float, yz: float) -> Array:
    """Return the matrix (3, 3) of a diagonal and the three entries above it."""
    return np.asarray(np.diag(diagonal) + np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]]))
