"""Axes and frame in the reason of a calibration: turned axes keep an ok, left-handed ones lose it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from calib import Reference, get
from calib.acceptance import unsupported
from calib.result import Calibration, Status
from recordings import Recording, read_recording
from validation.screening.axes import axes_and_frame
from validation.screening.screening import screen

CASES = Path(__file__).parents[2] / "recordings" / "cases"
REFERENCE = Reference(48_000.0)


def case(name: str) -> Recording:
    return read_recording(CASES / f"{name}.csv")


@pytest.mark.parametrize("method", ["ellipsoid", "gyro_ml", "gyro_accel_ml"])
@pytest.mark.parametrize(
    ("name", "kind", "told"),
    [
        ("imu_ok", "ok", ""),
        ("imu_swapped_proper", "ok", "--axes y,x,-z"),
        ("imu_swapped_lefthanded", "unobservable", "left-handed: no turn makes it right"),
    ],
)
def test_the_status_of_swapped_axes(name: str, kind: str, told: str, method: str) -> None:
    screened = screen(case(name))
    found = screened.judged(get(method).fit(screened.recording, REFERENCE))
    assert found.status.kind == kind
    assert told in found.status.reason


def test_the_named_map_mends_the_axes() -> None:
    swapped = read_recording(CASES / "imu_swapped_proper.csv", maps=[
        "mag_x_nT=mag_y_nT", "mag_y_nT=mag_x_nT", "mag_z_nT=mag_z_nT,scale=-1",
    ])  # fmt: skip
    np.testing.assert_allclose(swapped.mag_nT, case("imu_ok").mag_nT)
    assert axes_and_frame(swapped) == []


def test_a_magnetometer_alone_is_not_judged() -> None:
    assert axes_and_frame(case("base")) == []


def test_a_log_in_frd_is_named() -> None:
    time_s = np.arange(400) / 10
    accel = np.tile([0.0, 0.0, -9.8], (400, 1)) + np.random.default_rng(1).normal(0, 0.05, (400, 3))
    (fault,) = axes_and_frame(Recording(time_s, case("base").mag_nT[:400], accel_m_s2=accel))
    assert fault.kind == "frame"
    assert not fault.doubtful
    assert fault.text.endswith("--frame frd")


def test_a_reflection_is_no_ok() -> None:
    """The corrected field of a vector method that fits mirrored axes."""
    mirrored = Calibration(name="vector_least_squares", status=Status("ok"), matrix=np.diag([1.0, 1.0, -1.0]))
    status = unsupported(mirrored, np.zeros((100, 3)), REFERENCE)
    assert status is not None
    assert status.kind == "not_converged"
    assert "left-handed" in status.reason
