"""Attitude, gyro, gravity and field that agree, and each way in which they do not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.validation.inspection.recordings import FIELD_ENU_NT, GRAVITY_M_S2, moved, noise, one, sensor_data
from validation.inspection.finding import Finding
from validation.inspection.frames import frame_findings

SAMPLES = 3000
MOTION = moved(SAMPLES)
SOUND: dict[str, Any] = {
    "q": MOTION.q, "gyro": MOTION.rate_rad_s, "accel": MOTION.body(np.array([0.0, 0.0, GRAVITY_M_S2])),
}  # fmt: skip
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def findings(field_enu_nT: np.ndarray = FIELD_ENU_NT, **changed: Any) -> list[Finding]:
    columns = {name: values for name, values in (SOUND | changed).items() if values is not None}
    return frame_findings(sensor_data(MOTION.time_s, MOTION.body(field_enu_nT) + noise(SAMPLES, 5.0), **columns))


def test_sound_frames_agree() -> None:
    found = findings()
    assert {finding.level for finding in found} == {"ok"}
    assert one(found, "gyro_and_attitude").value == {
        "share": pytest.approx(1.0, abs=1e-3), "scale": pytest.approx(1.0, abs=0.01),
        "angle_deg": pytest.approx(0.0, abs=1.0), "lag_s": 0.0,
    }  # fmt: skip
    assert one(found, "gravity").value == pytest.approx(0.0, abs=0.1)


def test_the_fields_direction_in_the_world() -> None:
    """Inclination atan2(down, horizontal) and declination atan2(east, north), less than the iron's doing."""
    found = one(findings(), "field_direction")
    east, north, up = FIELD_ENU_NT
    assert found.value["down_deg"] == pytest.approx(np.degrees(np.arctan2(-up, np.hypot(east, north))), abs=0.1)
    assert found.value["east_of_north_deg"] == pytest.approx(np.degrees(np.arctan2(east, north)), abs=0.2)


def test_a_heading_counted_from_elsewhere() -> None:
    found = one(findings(np.array([20_000.0, -3000.0, -10_000.0])), "field_direction")
    assert found.level == "note"
    assert "98.5 degrees east of north" in found.text


@pytest.mark.parametrize(
    ("columns", "sign", "convention"),
    [([1, 2, 3, 0], 1, "x, y, z, w, body to world"), ([0, 1, 2, 3], -1, "w, x, y, z, world to body"),
     ([1, 2, 3, 0], -1, "x, y, z, w, world to body")],
)  # fmt: skip
def test_a_quaternion_in_another_convention(columns: list[int], sign: int, convention: str) -> None:
    q = (MOTION.q * [1, sign, sign, sign])[:, columns]
    found = findings(q=q)
    assert f"probably ({convention})" in one(found, "gyro_and_attitude").text
    assert one(found, "gyro_and_attitude").level == "warning"
    assert f"read as ({convention})" in one(found, "gravity").text


@pytest.mark.parametrize(("unit", "factor"), [("deg/s", 180 / np.pi), ("mrad/s", 1e3)])
def test_a_gyro_in_another_unit(unit: str, factor: float) -> None:
    for attitude in (MOTION.q, None):
        found = findings(gyro=factor * MOTION.rate_rad_s, q=attitude)
        about = one(found, "gyro_and_field" if attitude is None else "gyro_and_attitude")
        assert f"--map gyro_x_rad_s=<column>,unit={unit}" in about.text
        assert about.level == "warning"


def test_a_gyro_of_no_known_unit() -> None:
    assert "check its unit" in one(findings(gyro=3 * MOTION.rate_rad_s), "gyro_and_attitude").text
    assert "check its unit" in one(findings(gyro=3 * MOTION.rate_rad_s, q=None), "gyro_and_field").text


@pytest.mark.parametrize("rows", [-20, 15])
def test_an_attitude_that_is_late_or_early(rows: int) -> None:
    found = one(findings(q=np.roll(MOTION.q, rows, axis=0)), "gyro_and_attitude")
    assert found.value["lag_s"] == pytest.approx(rows / 50)
    assert ("late" if rows > 0 else "early") in found.text
    assert found.level == "warning"


def test_a_gyro_whose_axes_are_turned() -> None:
    """x and y exchanged by a turn of 90 degrees about z: the frame is named, and nothing is wrong with the rate."""
    turned = MOTION.rate_rad_s @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = one(findings(gyro=turned), "gyro_and_attitude")
    assert found.value["angle_deg"] == pytest.approx(90, abs=1)
    assert found.value["share"] == pytest.approx(1, abs=1e-3)
    assert "turned by 90 degrees" in found.text


@pytest.mark.parametrize(("angle_deg", "level"), [(3.0, "ok"), (7.0, "note")])
def test_a_mount_turned_by_a_few_degrees_is_named_and_by_fewer_not(angle_deg: float, level: str) -> None:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    turned = MOTION.rate_rad_s @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    found = one(findings(gyro=turned), "gyro_and_attitude")
    assert found.value["angle_deg"] == pytest.approx(angle_deg, abs=0.2)
    assert found.level == level


def test_a_gyro_of_another_motion() -> None:
    gyro = noise(SAMPLES, 1.0, seed=3)
    assert "attitude and gyro disagree" in one(findings(gyro=gyro), "gyro_and_attitude").text
    assert "does not follow the gyro" in one(findings(gyro=gyro, q=None), "gyro_and_field").text


def test_at_rest_nothing_is_compared() -> None:
    still = np.tile(MOTION.q[:1], (SAMPLES, 1))
    assert "turns too little" in one(findings(q=still, gyro=0 * MOTION.rate_rad_s), "gyro_and_attitude").text


def test_quaternions_off_their_norm() -> None:
    q = MOTION.q.copy()
    q[100:120] *= 1.3
    found = one(findings(q=q), "quaternion_norm")
    assert found.value == pytest.approx(0.3)
    assert found.text.startswith("20 quaternions are off norm 1")


def test_gravity_down_and_tilted() -> None:
    body = MOTION.body(np.array([0.0, 0.0, -GRAVITY_M_S2]))
    assert "points down" in one(findings(accel=body), "gravity").text
    tilted = MOTION.body(GRAVITY_M_S2 * np.array([1.0, 0.0, 1.0]) / np.sqrt(2))
    assert one(findings(accel=tilted), "gravity").value == pytest.approx(45, abs=0.1)


def test_directions_that_are_not_kept() -> None:
    """The body's own gravity and field, whatever the attitude."""
    fixed = np.tile([0.0, 0.0, GRAVITY_M_S2], (SAMPLES, 1))
    assert "no constant direction" in one(findings(accel=fixed), "gravity").text
    mag = np.tile([0.0, 0.0, 50_000.0], (SAMPLES, 1)) + noise(SAMPLES, 5.0)
    found = frame_findings(sensor_data(MOTION.time_s, mag, **SOUND))
    assert "hard iron, or turned frames" in one(found, "field_direction").text


def test_the_magnetometer_alone_tells_neither_axes_nor_frame() -> None:
    found = findings(q=None, gyro=None, accel=None)
    assert [finding.name for finding in found] == ["axes", "body_frame"]
    assert {finding.level for finding in found} == {"note"}
    assert one(found, "axes").value == {"verdict": "alone", "axes": []}
    assert "--frame frd otherwise" in one(found, "body_frame").text


@pytest.mark.parametrize(
    ("taken", "verdict", "told"),
    [
        ([[0, 1, 0], [1, 0, 0], [0, 0, -1]], "turned", "--axes y,x,-z"),
        ([[0, 1, 0], [1, 0, 0], [0, 0, 1]], "left_handed", "left-handed: no turn makes it right"),
        ([[1, 0, 0], [0, -1, 0], [0, 0, 1]], "left_handed", "--axes x,-y,z"),
    ],
)
def test_axes_that_are_not_those_of_the_gyro(taken: list[list[float]], verdict: str, told: str) -> None:
    mag_nT = (MOTION.body(FIELD_ENU_NT) + noise(SAMPLES, 5.0)) @ np.array(taken, float)
    found = one(frame_findings(sensor_data(MOTION.time_s, mag_nT, **SOUND)), "axes")
    assert found.level == "warning"
    assert found.value["verdict"] == verdict
    assert told in found.text
