"""The loop leaves what is another's alone."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from scenarios.errors import InputError
from sim.motion import drive
from sim.scenario import load
from sim.vehicles.quadrotor import Quadrotor

BALL = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"


@pytest.fixture
def told() -> Iterator[list[str]]:
    """What MuJoCo says to the handler of a user who has one."""
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    yield said
    mujoco.set_mju_user_warning(before)


def test_a_users_own_mujoco_still_warns(told: list[str]) -> None:
    model = mujoco.MjModel.from_xml_string(BALL)
    data = mujoco.MjData(model)
    data.qvel[0] = np.nan
    mujoco.mj_step(model, data)
    assert len(told) == 1
    assert "Nan" in told[0]


def test_our_own_losses_are_told_by_the_error_alone(told: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Quadrotor, "flow", lambda self, n, rng, memory: np.full((n, 3), 1e6))
    with pytest.raises(InputError, match="left its envelope"):
        list(drive(load("quad-calibration"), np.random.default_rng(0)))
    assert not told
