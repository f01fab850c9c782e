"""Root mean squares."""

from __future__ import annotations

import numpy as np
import pytest

from validation.signals.amplitude import column_rms, rms


def test_mean_and_deviation_add_in_squares() -> None:
    """rms^2 = mean^2 + variance, of all and of each column."""
    values = np.random.default_rng(0).normal([3.0, -1.0], [1.0, 2.0], (500, 2))
    np.testing.assert_allclose(column_rms(values), np.hypot(values.mean(axis=0), values.std(axis=0)), rtol=1e-12)
    assert rms(values) == pytest.approx(np.hypot(values.mean(), values.std()))
    assert rms([3.0, -4.0]) == pytest.approx(np.sqrt(12.5))
