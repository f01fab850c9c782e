"""Body directions in words: the same for what differs by rounding alone."""

from __future__ import annotations

import numpy as np
import pytest

from calib.observability import axis_text, main_axis, remedy_text, rounded_sizes


@pytest.mark.parametrize("rounding", [1e-9, -1e-9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_of_two_axes_that_are_equal_to_rounding_the_first_is_named(rounding: float, sign: float) -> None:
    direction = sign * 5.0 * np.array([0.7 + rounding, -0.7, rounding])
    assert axis_text(direction) == "body x (direction 0.71, -0.71, 0.00)"
    assert remedy_text(direction) == remedy_text(np.array([1.0, 0.0, 0.0]))


def test_an_axis_alone_needs_no_components() -> None:
    assert axis_text(np.array([0.05, 0.0, -3.0])) == "body z"
    assert axis_text(np.array([0.0, 0.6, 0.8])) == "body z (direction 0.00, 0.60, 0.80)"


@pytest.mark.parametrize("rounding", [-1e-9, 0.0, 1e-9])
@pytest.mark.parametrize("part", [0.5, 0.705, 0.995, 1.0])
def test_names_do_not_follow_rounding(rounding: float, part: float) -> None:
    """Another processor's last digits leave the axis: of equal components the first, whatever their size."""
    assert main_axis(np.array([0.0, part, part + rounding])) == 1
    assert np.argmax(rounded_sizes(np.array([1e9 * part, 1e9 * (part + rounding)]))) == 0
    assert main_axis(np.array([0.0, part, 1.1 * part])) == 2
