"""Strength and dip: the derivatives of the residuals are their differences."""

from __future__ import annotations

import numpy as np
import pytest

from calib.models.dip import DipSamples


@pytest.mark.parametrize("inclination_rad", [None, 0.4])
def test_slopes_are_differences_of_the_residuals(inclination_rad: float | None) -> None:
    rng = np.random.default_rng(0)
    towards, up = rng.normal(size=(2, 20, 3)) / np.sqrt(3.0)
    x = 1.05 * towards / np.linalg.norm(towards, axis=1)[:, None] + 0.1
    up /= np.linalg.norm(up, axis=1)[:, None]
    samples = DipSamples(x, up, np.eye(9).reshape(9, 3, 3), inclination_rad, 0.01, 0.02)
    theta = samples.start()
    theta += 0.02 * rng.normal(size=theta.shape)
    steps = 1e-6 * np.eye(len(theta))
    expected = np.array([samples.residuals(theta + one) - samples.residuals(theta - one) for one in steps]).T / 2e-6
    np.testing.assert_allclose(samples.slopes(theta), expected, atol=1e-7 * np.abs(expected).max())
