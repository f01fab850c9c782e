"""Compiled maps of points and attitudes against the same by numpy and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.numerics.points import turning_field
from calib.numerics.rates import body_rate
from recordings import Recording

RNG = np.random.default_rng(0)
RATE = RNG.normal(size=(50, 3))


def test_field_of_a_turning_body_solves_its_equation() -> None:
    """B h' = -B (w x h) for eddy currents."""
    centred, S, B = RNG.normal(size=(50, 3)), np.eye(3) + 0.1 * RNG.normal(size=(3, 3)), 0.1 * RNG.normal(size=(3, 3))
    h = turning_field(centred, S, B, RATE)
    np.testing.assert_allclose(h @ S.T - np.cross(RATE, h) @ B.T, centred, atol=1e-12)


def test_a_singular_system_is_an_error() -> None:
    with pytest.raises(ArithmeticError):
        turning_field(np.ones((1, 3)), np.zeros((3, 3)), np.zeros((3, 3)), RATE[:1])


def test_rate_of_an_attitude_is_the_mean_of_the_turns_beside_it() -> None:
    """By scipy's rotations, at uneven times, the quaternions of any sign; equal attitudes do not turn."""
    turn, time_s = Rotation.from_rotvec(RATE[[*range(49), 48]]), np.cumsum(RNG.uniform(0.1, 0.3, 50))
    steps = (turn[:-1].inv() * turn[1:]).as_rotvec() / np.diff(time_s)[:, None]
    padded = np.concatenate((steps[:1], steps, steps[-1:]))
    att_q = turn.as_quat(scalar_first=True) * RNG.choice([-1.0, 1.0], 50)[:, None]
    found = body_rate(Recording(time_s, RATE, att_q=att_q))
    assert found is not None
    np.testing.assert_allclose(found, (padded[:-1] + padded[1:]) / 2, atol=1e-12)
    assert not found[-1].any()
