"""A logged attitude at other times than its own."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.motion import attitude_at, attitude_course, quieter_rate
from recordings import Recording
from scenarios.arrays import Array
from sim.rotation import matrix_from_q

TIME_S = np.arange(0.0, 20.0, 0.1)


def _turned(time_s: Array) -> Array:
    """Quaternions (n, 4) of turns about the vertical at 0.3 rad/s."""
    half = 0.15 * time_s
    return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)


def test_between_its_values_an_attitude_turns_on_whichever_sign_they_have() -> None:
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(TIME_S), 1))
    between_s = TIME_S[:-1] + 0.04
    found = attitude_at(attitude_course(TIME_S, signs * _turned(TIME_S)), between_s)
    assert matrix_from_q(found) == pytest.approx(matrix_from_q(_turned(between_s)), abs=1e-6)


def test_behind_its_last_value_an_attitude_stands() -> None:
    """How it turned on is not known."""
    found = attitude_at(attitude_course(TIME_S, _turned(TIME_S)), TIME_S[-1] + np.array([0.0, 1.0, 50.0]))
    assert found == pytest.approx(np.repeat(_turned(TIME_S[-1:]), 3, axis=0))


@pytest.mark.parametrize(("every", "derived"), [(13, True), (8, False)])
def test_an_attitude_that_is_held_gives_no_rate(every: int, derived: bool) -> None:
    """A tenth of its rows may be: however noisy the gyro is."""
    q = _turned(TIME_S)
    again = np.arange(1, len(q), every)
    q[again] = q[again - 1]
    gyro = np.random.default_rng(0).normal(size=(len(q), 3))
    given = Recording(time_s=TIME_S, mag_nT=np.zeros((len(q), 3)), att_q=q, gyro_rad_s=gyro)
    assert (quieter_rate(given, STANDARD) is not gyro) is derived
