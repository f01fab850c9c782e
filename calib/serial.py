"""Calibrations as JSON: the keys shared by every command and every external calibrator."""

from __future__ import annotations

import itertools
import json
from typing import Any, NoReturn, get_args

import numpy as np

from calib.input_terms import InputTerm
from calib.result import OFFSET_NAMES, SCALAR_TERM, Calibration, Kind, Segment, Status
from scenarios.arrays import Array
from scenarios.errors import InputError

KEYS = (
    "name",
    "status",
    "reason",
    "offset_nT",
    "matrix",
    "eddy_s",
    "parameters",
    "covariance",
    "covariance_names",
    "history",
    "wall_s",
    "array_offset_nT",
    "array_matrix",
    "segments",
    "inputs",
)
INPUT_KEYS = ("channel", "gain_nT", "reference", "lag_s")
SEGMENT_KEYS = ("start_s", "offset_nT", "matrix")
KINDS: tuple[Kind, ...] = get_args(Kind)


def to_dict(calibration: Calibration) -> dict[str, Any]:
    """The calibration as plain lists, numbers and strings, under KEYS; offset and matrix None without an estimate."""

    def listed(array: Array | None) -> Any:
        return None if array is None else np.asarray(array).tolist()

    return {
        "name": calibration.name,
        "status": calibration.status.kind,
        "reason": calibration.status.reason,
        "offset_nT": listed(calibration.offset_nT) if calibration.has_estimate else None,
        "matrix": listed(calibration.matrix) if calibration.has_estimate else None,
        "eddy_s": listed(calibration.eddy_s),
        "parameters": {name: float(value) for name, value in calibration.parameters.items()},
        "covariance": listed(calibration.covariance),
        "covariance_names": list(calibration.covariance_names),
        "history": [float(value) for value in calibration.history],
        "wall_s": float(calibration.wall_s),
        "array_offset_nT": listed(calibration.array_offset_nT),
        "array_matrix": listed(calibration.array_matrix),
        "segments": [
            {"start_s": float(part.start_s), "offset_nT": listed(part.offset_nT), "matrix": listed(part.matrix)}
            for part in calibration.segments
        ],
        "inputs": [
            {
                "channel": term.channel,
                "gain_nT": listed(term.gain_nT),
                "reference": float(term.reference),
                "lag_s": float(term.lag_s),
            }
            for term in calibration.inputs
        ],
    }


def to_json(calibration: Calibration) -> str:
    """The calibration as one JSON object (floats survive the round trip exactly)."""
    return json.dumps(to_dict(calibration), allow_nan=False)


def from_json(text: str, *, name: str = "external", where: str = "calibration") -> Calibration:
    """Read a calibration that a program wrote, checking every value.

    `offset_nT` and `matrix` are required when the status is "ok" (which it is by default), unless `parameters` hold the
    terms of a scalar magnetometer; without them another status leaves the raw measurement. Raises InputError with one
    line for anything else than KEYS with finite values of the right shape.
    """

    def constant(word: str) -> NoReturn:
        raise InputError(f"{word} is not a number that JSON knows", where=where, do="write finite numbers or null")

    try:
        # an integer of any length is then finite, or infinite and refused
        data = json.loads(text, parse_int=float, parse_constant=constant)
    except json.JSONDecodeError as error:
        raise InputError(f"not JSON: {error}", where=where) from None
    except RecursionError:
        raise InputError("nested too deep", where=where) from None
    if not isinstance(data, dict):
        raise InputError(f"expected a JSON object, found {type(data).__name__}", where=where)
    unknown = sorted(set(data) - set(KEYS))
    if unknown:
        raise InputError(f"unknown keys {', '.join(unknown)}", where=where, do=f"known are {', '.join(KEYS)}")
    return _Reader(data, where).calibration(name)


class _Reader:
    """The checked values of one JSON object."""

    def __init__(self, data: dict[str, Any], where: str) -> None:
        self.data, self.where = {key: value for key, value in data.items() if value is not None}, where

    def calibration(self, name: str) -> Calibration:
        status = Status(self.kind(), self.text("reason", ""))
        names = self.names("covariance_names") or self.default_names()
        offset_nT, matrix = self.array("offset_nT", (3,)), self.array("matrix", (3, 3))
        parameters = self.parameters()
        needed = status.kind == "ok" and SCALAR_TERM not in parameters
        if needed and (offset_nT is None or matrix is None):
            self.fail("offset_nT" if offset_nT is None else "matrix", "missing, and the status is ok")
        covariance = self.covariance(len(names))
        array_offset_nT, array_matrix = self.sensors()
        return Calibration(
            name=self.text("name", name),
            status=status,
            offset_nT=np.zeros(3) if offset_nT is None else offset_nT,
            matrix=np.eye(3) if matrix is None else matrix,
            eddy_s=self.array("eddy_s", (3, 3)),
            parameters=parameters,
            covariance=covariance,
            covariance_names=names if covariance is not None else (),
            history=self.history(),
            wall_s=self.number("wall_s", self.data.get("wall_s", 0.0)),
            array_offset_nT=array_offset_nT,
            array_matrix=array_matrix,
            segments=self.segments(),
            inputs=self.inputs(),
        )

    def fail(self, key: str, what: str) -> NoReturn:
        raise InputError(what, where=f"{self.where}: {key}")

    def kind(self) -> Kind:
        value = self.data.get("status", "ok")
        for kind in KINDS:
            if value == kind:
                return kind
        self.fail("status", f"{value!r} is none of {', '.join(KINDS)}")

    def text(self, key: str, default: str) -> str:
        value = self.data.get(key, default)
        return value if isinstance(value, str) else self.fail(key, f"expected text, found {value!r}")

    def names(self, key: str) -> tuple[str, ...]:
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value) or len(set(value)) < len(value):
            self.fail(key, "expected a list of different names")
        return tuple(value)

    def default_names(self) -> tuple[str, ...]:
        """A covariance of size 3 without names is the offset's."""
        covariance = self.data.get("covariance")
        if covariance is None:
            return ()
        if not isinstance(covariance, list) or len(covariance) != len(OFFSET_NAMES):
            self.fail("covariance_names", "missing: name the covariance's parameters, or give the offset's 3 x 3")
        return OFFSET_NAMES

    def number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(float(value)):
            self.fail(key, f"expected a finite number, found {value!r}")
        return float(value)

    def array(self, key: str, shape: tuple[int, ...]) -> Array | None:
        if key not in self.data:
            return None
        cells = np.array(self.data[key], dtype=object)
        if cells.shape != shape:
            self.fail(key, f"expected {' x '.join(map(str, shape))} numbers, found shape {cells.shape}")
        return np.array([self.number(key, v) for v in cells.flat]).reshape(shape)

    def sensors(self) -> tuple[Array | None, Array | None]:
        """Offsets (k, 3) and matrices (k, 3, 3) of an array: both or neither."""
        given = [key for key in ("array_offset_nT", "array_matrix") if key in self.data]
        if not given:
            return None, None
        parts = self.data[given[0]]
        if not isinstance(parts, list):
            self.fail(given[0], "expected a list with a part for each sensor")
        offset_nT = self.array("array_offset_nT", (len(parts), 3))
        matrix = self.array("array_matrix", (len(parts), 3, 3))
        if offset_nT is None or matrix is None:
            self.fail("array_matrix" if matrix is None else "array_offset_nT", f"missing beside {given[0]}")
        return offset_nT, matrix

    def segments(self) -> tuple[Segment, ...]:
        """Segments in order of time."""
        parts = tuple(part.segment() for part in self.objects("segments", SEGMENT_KEYS))
        if any(b.start_s <= a.start_s for a, b in itertools.pairwise(parts)):
            self.fail("segments", "start_s must increase")
        return parts

    def objects(self, key: str, keys: tuple[str, ...]) -> list[_Reader]:
        """Readers of a list of objects."""
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(part, dict) for part in value):
            self.fail(key, f"expected a list of objects with {', '.join(keys)}")
        return [_Reader(part, f"{self.where}: {key}[{i}]") for i, part in enumerate(value)]

    def inputs(self) -> tuple[InputTerm, ...]:
        """Terms of inputs, each of another channel."""
        terms = tuple(part.input_term() for part in self.objects("inputs", INPUT_KEYS))
        if len({term.channel for term in terms}) < len(terms):
            self.fail("inputs", "a channel has two terms")
        return terms

    def input_term(self) -> InputTerm:
        """This object as the term of an input."""
        unknown = sorted(set(self.data) ^ set(INPUT_KEYS))
        gain_nT, channel = self.array("gain_nT", (3,)), self.text("channel", "")
        if unknown or gain_nT is None or not channel:
            self.fail(", ".join(unknown), f"missing or unknown; an input has {', '.join(INPUT_KEYS)}")
        reference, lag_s = (self.number(key, self.data[key]) for key in INPUT_KEYS[2:])
        if lag_s < 0:
            self.fail("lag_s", "expected a time constant that is not negative")
        return InputTerm(channel, gain_nT, reference, lag_s)

    def segment(self) -> Segment:
        """This object as one segment."""
        unknown = sorted(set(self.data) ^ set(SEGMENT_KEYS))
        offset_nT, matrix = self.array("offset_nT", (3,)), self.array("matrix", (3, 3))
        if unknown or offset_nT is None or matrix is None:
            self.fail(", ".join(unknown), f"missing or unknown; a segment has {', '.join(SEGMENT_KEYS)}")
        return Segment(self.number("start_s", self.data["start_s"]), offset_nT, matrix)

    def covariance(self, size: int) -> Array | None:
        value = self.array("covariance", (size, size)) if size else None
        if value is None:
            return None
        if not np.allclose(value, value.T, rtol=1e-6) or (np.diag(value) < 0).any():
            self.fail("covariance", "expected a symmetric matrix with a diagonal that is not negative")
        return value

    def parameters(self) -> dict[str, float]:
        value = self.data.get("parameters", {})
        if not isinstance(value, dict):
            self.fail("parameters", "expected an object of named numbers")
        return {key: self.number(f"parameters.{key}", v) for key, v in value.items()}

    def history(self) -> tuple[float, ...]:
        value = self.data.get("history", [])
        if not isinstance(value, list):
            self.fail("history", "expected a list of numbers")
        return tuple(self.number("history", v) for v in value)
