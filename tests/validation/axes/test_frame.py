"""Body frame of a log from gravity: upright vehicles in FLU and FRD, attitudes in ENU and NED."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.axes_alarms import Conditions, Log, simulated
from scenarios.arrays import Array
from validation.axes.estimate import axes_of
from validation.axes.frame import BodyFrame, frame_of

DOWN = np.diag([1.0, -1.0, -1.0])
NED_FROM_ENU = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
UPRIGHT = Conditions(motion="vehicle", rows=1000, tilt_deg=10.0)


def in_frd(log: Log) -> Log:
    """Return the log of a vehicle whose axes are forward, right, down, and whose attitude is FRD to NED."""
    turned = (
        Rotation.from_matrix(NED_FROM_ENU) * Rotation.from_quat(log.q, scalar_first=True) * Rotation.from_matrix(DOWN)
    )
    vectors = {name: getattr(log, name) @ DOWN for name in ("mag_nT", "gyro", "accel")}
    return replace(log, **vectors, q=turned.as_quat(scalar_first=True))


def frame(log: Log, *, accel: bool = True, q: bool = False, mag_nT: Array | None = None) -> BodyFrame:
    columns = {"accel": log.accel if accel else None, "q": log.q if q else None}
    axes = axes_of(log.time_s, log.mag_nT if mag_nT is None else mag_nT, gyro=log.gyro, **columns)
    return frame_of(columns["accel"], columns["q"], axes)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("q", [False, True])
def test_an_upright_vehicle_tells_its_frame(seed: int, q: bool) -> None:
    log = simulated(np.random.default_rng(seed), UPRIGHT)
    assert frame(log, q=q).name == "flu"
    assert not frame(log, q=q).wrong
    found = frame(in_frd(log), q=q)
    assert found.name == "frd"
    assert found.text.endswith("--frame frd.")


def test_a_tumbled_sensor_tells_its_frame_by_the_attitude_alone() -> None:
    log = simulated(np.random.default_rng(1), Conditions())
    assert frame(log).name == ""
    assert "nothing in the log tells; --frame frd otherwise" in frame(log).text
    assert frame(log, q=True).name == "flu"
    assert frame(in_frd(log), q=True).name == "frd"


def test_an_accelerometer_of_opposite_sign_is_not_taken_for_frd() -> None:
    """As phones that log gravity rather than specific force: the field is along the reading in the north."""
    log = simulated(np.random.default_rng(2), replace(UPRIGHT, tilt_deg=25.0, shaking_m_s2=0.0))
    found = frame(replace(log, accel=-log.accel))
    assert found.contradicted
    assert "opposite sign of the accelerometer" in found.text


def test_attitude_and_accelerometer_that_contradict_each_other() -> None:
    """A body in FLU whose attitude turns to north, east, down."""
    log = simulated(np.random.default_rng(3), UPRIGHT)
    turned = Rotation.from_matrix(NED_FROM_ENU) * Rotation.from_quat(log.q, scalar_first=True)
    assert frame(replace(log, q=turned.as_quat(scalar_first=True)), q=True).contradicted


def test_nothing_tells_without_accelerometer() -> None:
    assert frame(simulated(np.random.default_rng(1), UPRIGHT), accel=False, q=True) == BodyFrame("", "")


def test_a_stated_frame_is_told_and_contradicted() -> None:
    log = simulated(np.random.default_rng(1), UPRIGHT)
    flu = axes_of(log.time_s, log.mag_nT, accel=log.accel, stated="frd")
    assert frame_of(log.accel, None, flu).text.startswith("Frame: FRD (forward, right, down) as stated, turned to FLU")
    frd = in_frd(log)
    found = frame_of(frd.accel, None, axes_of(frd.time_s, frd.mag_nT, accel=frd.accel, stated="frd"))
    assert found.wrong
    assert found.text.endswith("--frame flu.")


def test_the_option_acts_before_a_stated_frame_is_turned() -> None:
    """Log in FRD, magnetometer with axes y, x, -z of it: the option is the map in FRD."""
    frd = in_frd(simulated(np.random.default_rng(2), Conditions()))
    taken = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    swapped = frd.mag_nT @ taken
    read = {"gyro": frd.gyro @ DOWN, "accel": frd.accel @ DOWN}
    found = axes_of(frd.time_s, swapped @ DOWN, **read, stated="frd")
    (one,) = found.maps
    assert found.option(one) == "y,x,-z"
