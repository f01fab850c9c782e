"""Axes and frame of simulated runs of the catalogue: those of the contract, whatever the motion and its noise."""

from __future__ import annotations

import numpy as np
import pytest

import magbench
from validation.axes.estimate import axes_of
from validation.axes.frame import frame_of
from validation.axes.wording import axes_verdict


@pytest.mark.parametrize("scenario", ["tumble", "standard-full", "turntable-three-turns", "gradiometer-turntable"])
def test_simulated_runs_have_agreeing_axes_in_flu(scenario: str) -> None:
    log, _ = magbench.simulate(scenario)
    measured = {"gyro": log.gyro_rad_s, "accel": log.accel_m_s2, "q": log.att_q}
    found = axes_of(log.time_s, log.mag_nT, **measured)
    assert axes_verdict(found).kind == "agree"
    assert frame_of(log.accel_m_s2, log.att_q, found).name == "flu"
    mirrored = axes_of(log.time_s, log.mag_nT @ np.diag([1.0, -1.0, 1.0]), **measured)
    assert not mirrored.agree
