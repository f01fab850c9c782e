"""Findings as rows: the mark, the few numbers that fit, and none of the rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reports.text.inspection import finding_name, value_and_unit
from validation.inspection.finding import Finding


@pytest.mark.parametrize(
    ("value", "text"),
    [(True, "yes"), (False, "no"), (12_345, "12345"), (3.14159, "3.14"), (np.float64(0.5), "0.5"), ([5.0, 5.0], "5"),
     ([1.0, 2.0, 3.0], "1, 2, 3"), ([1.0] * 4, ""), ([], ""), ({"a": 1}, ""), (["x"], ""), ("text", "")],
)  # fmt: skip
def test_a_value_that_fits_and_its_unit(value: Any, text: str) -> None:
    assert value_and_unit(Finding("values", "step", value, "nT", "…")) == (text, "nT" if text else "")


def test_the_sensor_of_an_array_is_in_the_name() -> None:
    assert finding_name(Finding("noise", "full_scale", 1, "", "…", sensor=2)) == "full scale, sensor 2"
    assert finding_name(Finding("noise", "full_scale", 1, "", "…")) == "full scale"
