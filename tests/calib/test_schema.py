"""The published schema and the reader take the same calibrations, but for what a schema cannot say."""

from __future__ import annotations

import itertools
import json
import re
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from calib import from_json
from calib.schema import json_schema
from calib.serial import KEYS
from scenarios.errors import InputError

VECTOR, MATRIX = [1.0, 2, 3], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
SEGMENT = {"start_s": 0.0, "offset_nT": VECTOR, "matrix": MATRIX}
INPUT = {"channel": "current_1_A", "gain_nT": VECTOR, "reference": 0.0, "lag_s": 0.3}
WHOLE: dict[str, Any] = {
    "name": "mine",
    "status": "ok",
    "reason": "",
    "offset_nT": VECTOR,
    "matrix": MATRIX,
    "eddy_s": MATRIX,
    "parameters": {"rounds": 3},
    "covariance": MATRIX,
    "covariance_names": ["offset_x_nT", "offset_y_nT", "offset_z_nT"],
    "history": [3.0, 2.0],
    "wall_s": 0.1,
    "array_offset_nT": [VECTOR, VECTOR],
    "array_matrix": [MATRIX, MATRIX],
    "segments": [SEGMENT, {**SEGMENT, "start_s": 5.0}],
    "inputs": [INPUT, {**INPUT, "channel": "throttle"}],
}
VALUES: list[Any] = [
    None, True, 0, -3.5, "", "ok", "unobservable", "fine", [], {}, [1.0], VECTOR, [*VECTOR, 4], ["a", "b"], ["a", "a"],
    [1, 2, "3"], [1, 2, None], [1, 2, True], MATRIX, [VECTOR, VECTOR], [VECTOR, [1, 2]], [MATRIX], [[[1.0]]], {"a": 1},
    {"a": None}, {"a": "b"}, {"permanent_x_nT": 3.0}, [SEGMENT],
    [{**SEGMENT, "end_s": 1}], [{"start_s": 0}], [{**SEGMENT, "matrix": None}],
    [INPUT], [INPUT, INPUT], [{**INPUT, "lag_s": -1.0}], [{**INPUT, "channel": ""}], [{**INPUT, "unit": "A"}],
    [VECTOR], 1e308,
]  # fmt: skip
NOT_IN_A_SCHEMA = re.compile(
    r"symmetric|must increase|two terms|covariance: expected|array_(matrix|offset_nT): expected \d"
)
"""What the reader says of values that hang together with others in a way that no schema tells."""


def taken(data: object) -> tuple[bool, str]:
    """Whether the reader takes it, else what it says."""
    try:
        from_json(json.dumps(data))
    except InputError as error:
        return False, str(error)
    return True, ""


@pytest.fixture(scope="module")
def valid() -> Draft202012Validator:
    schema = json_schema()
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def compare(valid: Draft202012Validator, data: object) -> None:
    by_reader, said = taken(data)
    by_schema = valid.is_valid(data)
    assert by_schema or not by_reader, f"the schema refuses {data}"
    assert by_reader or not by_schema or NOT_IN_A_SCHEMA.search(said), f"the schema takes {data}; the reader: {said}"


def test_every_key_is_in_the_schema_and_nothing_else() -> None:
    assert list(json_schema()["properties"]) == list(KEYS)
    assert set(WHOLE) == set(KEYS)


@pytest.mark.parametrize("key", KEYS)
def test_a_value_of_another_form_is_refused_by_both_or_by_none(valid: Draft202012Validator, key: str) -> None:
    least = {"offset_nT": VECTOR, "matrix": MATRIX}
    for value in VALUES:
        compare(valid, WHOLE | {key: value})
        compare(valid, least | {key: value})
        compare(valid, {"status": "not_converged", key: value})


def test_any_two_keys_together(valid: Draft202012Validator) -> None:
    for keys in itertools.combinations(KEYS, 2):
        compare(valid, {key: WHOLE[key] for key in keys})
        compare(valid, {key: value for key, value in WHOLE.items() if key not in keys})
        compare(valid, WHOLE | dict.fromkeys(keys))


def test_what_is_no_object_or_has_other_keys_is_refused_by_both(valid: Draft202012Validator) -> None:
    assert valid.is_valid(WHOLE)
    assert taken(WHOLE)[0]
    for data in (*VALUES, WHOLE | {"offset": VECTOR}, {}):
        compare(valid, data)
        assert not valid.is_valid(data)
