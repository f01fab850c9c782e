"""A late attitude is that of a time before, however a run is cut into blocks."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings.columns import ATTITUDE
from scenarios.arrays import Array
from sim.late_attitude import LateAttitude
from sim.simulation import blocks, plan
from tests.short import short

TIME_S = np.arange(200) / 10.0


def _turning(time_s: Array) -> Array:
    """Unit quaternions (n, 4), w first, of a turn by half a radian a second about a slanted axis."""
    vectors = 0.5 * time_s[:, None] * np.array([[0.6, 0.0, 0.8]])
    return np.asarray(Rotation.from_rotvec(vectors).as_quat()[:, [3, 0, 1, 2]])


@pytest.mark.parametrize("delay_s", [0.04, 0.1, 0.73, 3.0])
def test_each_row_holds_the_attitude_of_a_delay_before(delay_s: float) -> None:
    late = LateAttitude(delay_s).of(TIME_S, _turning(TIME_S))
    wanted = _turning(np.maximum(TIME_S - delay_s, 0.0))
    assert np.abs((late * wanted).sum(axis=1)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("length", [1, 7, 50])
def test_blocks_change_nothing(length: int) -> None:
    q, late = _turning(TIME_S), LateAttitude(0.73)
    parts = [late.of(TIME_S[i : i + length], q[i : i + length]) for i in range(0, len(q), length)]
    assert np.array_equal(np.concatenate(parts), LateAttitude(0.73).of(TIME_S, q))


def test_without_a_delay_nothing_is_touched() -> None:
    q = _turning(TIME_S)
    assert LateAttitude(0.0).of(TIME_S, q) is q


def _logged_q(delay_s: float) -> Array:
    """Attitude (n, 4) that a short run of the quadrotor logs at 10 Hz."""
    quiet = ("sampling.rate_hz=10", "navigation.attitude_noise_std_deg=0", f"navigation.attitude_delay_s={delay_s}")
    made = plan(short("quad-calibration", *quiet), 0, 1)
    return np.concatenate([np.column_stack([block[name] for name in ATTITUDE]) for block in blocks(made)])


def test_a_run_logs_the_attitude_of_a_row_before() -> None:
    late, true = _logged_q(0.1), _logged_q(0.0)
    assert np.abs((late[1:] * true[:-1]).sum(axis=1)) == pytest.approx(1.0, abs=1e-12)
    assert np.abs((late[1:] * true[1:]).sum(axis=1)).min() < 1 - 1e-9
