"""The rate of a direction that turns evenly, whatever the sampling."""

from __future__ import annotations

import numpy as np
import pytest

from validation.signals.direction_rate import median_rate_rad_s


@pytest.mark.parametrize("step_s", [0.01, 0.2])
def test_an_even_turn_has_its_rate(step_s: float) -> None:
    time_s = step_s * np.arange(200)
    u = np.column_stack([np.cos(0.7 * time_s), np.sin(0.7 * time_s), 0 * time_s])
    assert median_rate_rad_s(u, time_s, 0.1) == pytest.approx(0.7)
