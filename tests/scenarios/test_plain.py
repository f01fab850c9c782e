"""Plain values for JSON: the same numbers, lists for arrays, null for what is not finite."""

from __future__ import annotations

import json

import numpy as np

from scenarios.plain import json_ready


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
    plain = json_ready(value)
    assert json.loads(json.dumps(plain, allow_nan=False)) == {
        "1": [[1.5, None], [None, -2.0]], "number": 0.5, "count": 3, "flag": True, "pair": [1, None], "text": "NaN",
        "none": None, "nested": [{"deep": None}],
    }  # fmt: skip
    assert plain["flag"] is True
    assert isinstance(plain["count"], int)
