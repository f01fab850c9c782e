"""Plain values for JSON: the same numbers, lists for arrays, null for what is not finite."""

from __future__ import annotations

import json

import numpy as np

from scenarios.plain import json_ready, plain


def test_arrays_become_lists_and_what_is_not_finite_null() -> None:
    value = {
        1: np.array([[1.5, np.nan], [np.inf, -2.0]]),
        "number": np.float32(0.5),
        "count": np.int64(3),
        "flag": np.bool_(True),
        "pair": (1, float("-inf")),
        "text": "NaN",
        "none": None,
        "nested": [{"deep": np.float64("nan")}],
    }
    ready = json_ready(value)
    assert json.loads(json.dumps(ready, allow_nan=False)) == {
        "1": [[1.5, None], [None, -2.0]], "number": 0.5, "count": 3, "flag": True, "pair": [1, None], "text": "NaN",
        "none": None, "nested": [{"deep": None}],
    }  # fmt: skip
    assert ready["flag"] is True
    assert isinstance(ready["count"], int)


def test_plain_keeps_what_is_not_finite_and_what_it_does_not_know() -> None:
    kept = object()
    found = plain({"a": (np.float64("inf"), kept), "b": np.eye(2)})
    assert found == {"a": [float("inf"), kept], "b": [[1.0, 0.0], [0.0, 1.0]]}
    assert isinstance(found["a"][0], float)
