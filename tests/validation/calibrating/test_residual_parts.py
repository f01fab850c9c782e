"""The residual of a calibration by phase and by channel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status
from recordings import Recording
from validation.calibrating.residual_parts import by_channel, by_phase, strength_residual

RNG = np.random.default_rng(8)
UP = Rotation.random(2000, random_state=1).apply([0.0, 0.0, 1.0])
LOG = Recording(np.arange(2000) * 0.1, 48_000 * UP)


def slow(seed: int) -> np.ndarray:
    """A random walk, which goes with any other random walk by chance."""
    return np.cumsum(np.random.default_rng(seed).standard_normal(2000))


def test_the_residual_is_the_strength_beyond_the_fields() -> None:
    raw = Calibration(name="none", status=Status("ok"))
    np.testing.assert_allclose(strength_residual(raw, LOG, Reference(47_900.0)), 100.0, rtol=1e-9)


def test_phases_come_in_order_with_their_mean_and_rms() -> None:
    phase = np.where(np.arange(2000) < 500, "turn", "cruise")
    found = by_phase(np.where(phase == "turn", 3.0, -4.0), replace(LOG, phase=phase))
    assert [(one.phase, one.samples, one.mean_nT, one.rms_nT) for one in found] == [
        ("turn", 500, 3.0, 3.0),
        ("cruise", 1500, -4.0, 4.0),
    ]
    assert by_phase(np.zeros(2000), LOG) == ()


def test_a_channel_that_the_residual_follows_is_found_with_its_slope() -> None:
    current = RNG.uniform(0, 20, 2000)
    residual_nT = 5.0 * current + RNG.normal(0, 10, 2000)
    (found,) = by_channel(residual_nT, replace(LOG, current_A=current[:, None], channels={"other": slow(2)}))
    assert found.channel == "current_1_A"
    assert found.slope_nT == pytest.approx(5.0, rel=0.05)
    assert found.share == pytest.approx(np.corrcoef(current, residual_nT)[0, 1] ** 2)


def test_slow_channels_seldom_go_with_a_slow_residual_by_chance() -> None:
    found = [by_channel(slow(100 + k), replace(LOG, channels={"drift": slow(500 + k)})) for k in range(200)]
    assert sum(map(bool, found)) <= 12
