"""JSON Schema of a calibration's JSON, for authors in other languages."""

from __future__ import annotations

import sys
from typing import Any

from calib.result import SCALAR_TERM
from calib.serial import INPUT_KEYS, KINDS, SEGMENT_KEYS
from scenarios.spec import DIALECT

Schema = dict[str, Any]
NUMBER: Schema = {"type": "number", "minimum": -sys.float_info.max, "maximum": sys.float_info.max}
TEXT: Schema = {"type": "string"}
NAMED, LENGTH = {**TEXT, "minLength": 1}, {**NUMBER, "minimum": 0}
"""A text that is not empty, and a number that is not negative."""


def _several(item: Schema, count: int | None = None) -> Schema:
    """A list of items, as many as there are or `count`."""
    return {"type": "array", "items": item} | ({} if count is None else {"minItems": count, "maxItems": count})


def _object(values: dict[str, Schema]) -> Schema:
    return {"type": "object", "properties": values, "required": [*values], "additionalProperties": False}


def _given(**values: Schema) -> Schema:
    """Schema that requires keys, in the given forms."""
    return {"required": [*values], "properties": {key: {"not": {"type": "null"}, **one} for key, one in values.items()}}


def _if(properties: dict[str, Schema], then: Schema) -> Schema:
    return {"if": {"properties": properties}, "then": then}


def _if_given(key: str, then: Schema) -> Schema:
    return {"if": _given(**{key: {}}), "then": then}


VECTOR, MATRIX = _several(NUMBER, 3), _several(_several(NUMBER, 3), 3)
OFFSETS, MATRICES = {**_several(VECTOR), "minItems": 1}, {**_several(MATRIX), "minItems": 1}
"""Of an array, a sensor each."""
VALUES: dict[str, Schema] = {
    "name": TEXT,
    "status": {"enum": [*KINDS], "default": "ok"},
    "reason": {**TEXT, "description": "why there is no estimate, or why it is not to be trusted"},
    "offset_nT": {**VECTOR, "description": "b of m = S h + b, body frame: x forward, y left, z up"},
    "matrix": {**MATRIX, "description": "the inverse of S, row by row: h = matrix (m - offset)"},
    "eddy_s": {**MATRIX, "description": "B of m = S h + b + B dh/dt"},
    "parameters": {"type": "object", "additionalProperties": NUMBER},
    "covariance": _several(_several(NUMBER)),
    "covariance_names": {**_several(TEXT), "uniqueItems": True},
    "history": {**_several(NUMBER), "description": "the method's own measure of convergence, a value a round"},
    "wall_s": NUMBER,
    "array_offset_nT": OFFSETS,
    "array_matrix": MATRICES,
    "segments": _several(_object(dict(zip(SEGMENT_KEYS, (NUMBER, VECTOR, MATRIX), strict=True)))),
    "inputs": _several(
        _object(
            dict(zip(INPUT_KEYS, ({**TEXT, "minLength": 1}, VECTOR, NUMBER, {**NUMBER, "minimum": 0}), strict=True))
        )
    ),
}
"""What stands under each key, where it is not null."""


def json_schema() -> Schema:
    """JSON Schema (2020-12) of what `calib.from_json` takes.

    Left to the reader is what a schema cannot say: a covariance is symmetric, with a diagonal that is not negative, and
    has a row a name; both parts of an array have as many sensors; segments are in order of time; each input is of
    another channel.
    """
    return {
        "$schema": DIALECT,
        "title": "calibration",
        "type": "object",
        "properties": {key: {"anyOf": [value, {"type": "null"}]} for key, value in VALUES.items()},
        "additionalProperties": False,
        "allOf": [
            _if(
                {"status": {"enum": ["ok", None]}},
                {"anyOf": [_given(offset_nT=VECTOR, matrix=MATRIX), _given(parameters={"required": [SCALAR_TERM]})]},
            ),
            _if_given("array_offset_nT", _given(array_matrix=MATRICES)),
            _if_given("array_matrix", _given(array_offset_nT=OFFSETS)),
            _if_given("covariance", {"anyOf": [_given(covariance_names={"minItems": 1}), _given(covariance=MATRIX)]}),
        ],
    }
