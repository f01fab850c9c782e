"""Heading errors against analytic ones, in a frame of the test's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status, get
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.heading_error import heading_error
from validation.assessment.lean import Lean
from validation.assessment.level_flight import LevelFlight, level_flight
from validation.assessment.posterior import SensorDraws

FLIGHT = LevelFlight(50_000.0, float(np.radians(60.0)), "the field vector", Lean((0.0, 0.0), 0.0, 1.0))


def fit(offset_nT: Array, matrix: Array) -> Calibration:
    return Calibration(name="test", status=Status("ok"), offset_nT=offset_nT, matrix=matrix)


def sensor(offset_nT: Array, S: Array) -> SensorDraws:
    return SensorDraws(offset_nT[None], S[None], np.zeros((1, 2, 3)), 50_000.0)


def test_an_offset_across_gives_a_sine_over_the_headings() -> None:
    """Error b / H sin: rms b / (H sqrt 2), H = 25,000 nT; along z none."""
    perfect = sensor(np.zeros(3), np.eye(3))
    off = perfect.heading_rms_deg(fit(np.array([200.0, 0.0, 0.0]), np.eye(3)), FLIGHT, turned=False)
    assert off[0] == pytest.approx(np.degrees(200.0 / 25_000.0) / np.sqrt(2), rel=1e-4)
    none = perfect.heading_rms_deg(fit(np.array([0.0, 0.0, 200.0]), np.eye(3)), FLIGHT, turned=False)
    assert none[0] < 1e-9


def test_a_stretch_gives_two_cycles_a_turn() -> None:
    """S = 1 + e x x': error e / 2 sin 2 psi, rms e / (2 sqrt 2)."""
    stretched = sensor(np.zeros(3), np.diag([1.01, 1.0, 1.0]))
    found = stretched.heading_rms_deg(fit(np.zeros(3), np.eye(3)), FLIGHT, turned=False)
    assert found[0] == pytest.approx(np.degrees(0.01 / 2.0) / np.sqrt(2), rel=0.02)


def test_a_yaw_misalignment_counts_only_where_the_turn_is_determined() -> None:
    angle = np.radians(3.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    turned = sensor(np.zeros(3), turn)
    assert turned.heading_rms_deg(fit(np.zeros(3), np.eye(3)), FLIGHT, turned=False)[0] < 1e-9
    assert turned.heading_rms_deg(fit(np.zeros(3), np.eye(3)), FLIGHT, turned=True)[0] == pytest.approx(3.0)


def test_a_common_scale_turns_no_heading() -> None:
    larger = sensor(np.zeros(3), 1.1 * np.eye(3))
    assert larger.heading_rms_deg(fit(np.zeros(3), np.eye(3)), FLIGHT, turned=False)[0] < 1e-9


def test_the_dip_is_the_vectors_then_the_accelerometers_then_assumed() -> None:
    down = np.radians(40.0)
    field = np.tile([np.cos(down), 0.0, -np.sin(down)], (50, 1)) * 50_000.0
    plain = Recording(np.arange(50.0), field)
    levelled = Recording(np.arange(50.0), field, accel_m_s2=np.tile([0.0, 0.0, 9.81], (50, 1)))
    known = Reference.of_vector((0.0, 30_000.0, -30_000.0))
    dips = [
        np.degrees(level_flight(one, reference, field).dip_rad)
        for one, reference in ((levelled, known), (levelled, Reference(5e4)), (plain, Reference(5e4)))
    ]
    assert dips == pytest.approx([45.0, 40.0, 60.0])


def banked(speed_m_s: float, attitude: bool) -> Recording:
    """A level circle at 0.2 rad/s, leaning by w v / g to the inside, the left."""
    time_s = np.arange(0.0, 120.0, 0.1)
    yaw, bank = 0.2 * time_s, np.arctan(0.2 * speed_m_s / 9.80665)
    turn = Rotation.from_euler("ZYX", np.column_stack((yaw, 0 * yaw, 0 * yaw - bank)))
    place = speed_m_s / 0.2 * np.column_stack((np.sin(yaw), -np.cos(yaw), 0 * yaw))
    rate = turn.inv().apply([0.0, 0.0, 0.2])
    q = turn.as_quat(scalar_first=True) if attitude else None
    return Recording(time_s, turn.inv().apply([0.0, 25e3, -43e3]), gyro_rad_s=rate, att_q=q, pos_enu_m=place)


@pytest.mark.parametrize("attitude", [True, False])
def test_the_lean_of_a_banked_turn_comes_from_the_attitude_or_the_speed(attitude: bool) -> None:
    lean = Lean.of(banked(4.0, attitude))
    assert np.hypot(*lean.mean_rad) == pytest.approx(0.2 * 4.0 / 9.80665, rel=0.05)
    up = Rotation.from_euler("X", -np.arctan(0.2 * 4.0 / 9.80665)).inv().apply([0.0, 0.0, 1.0])
    assert np.sign(lean.mean_rad[1]) == np.sign(up[1])


def test_a_planar_calibration_of_a_banked_turn_has_the_bank_in_its_heading_error() -> None:
    """The offset holds F sin(dip) tan(bank) of z: over the horizontal field H, tan(dip) tan(bank) / sqrt 2."""
    recording, known = banked(4.0, True), Reference.of_vector((0.0, 25e3, -43e3))
    planar = get("planar").fit(recording, known)
    found = heading_error(planar, None, level_flight(recording, known, recording.mag_nT))
    assert found is not None
    expected = np.degrees(43.0 / 25.0 * 0.2 * 4.0 / 9.80665 / np.sqrt(2.0))
    assert found.low < expected < found.high
    assert found.value == pytest.approx(expected, rel=0.1)


def test_without_an_estimate_there_is_no_heading_error() -> None:
    failed = Calibration(name="test", status=Status("not_converged", "no"))
    assert heading_error(failed, None, FLIGHT) is None


def test_the_dip_comes_from_the_rows_with_a_specific_force() -> None:
    """Loggers write (0, 0, 0) before the accelerometer answers."""
    field_nT = np.tile([17_000.0, 0.0, -45_000.0], (10, 1))
    accel = np.tile([0.0, 0.0, 9.81], (10, 1))
    accel[:4] = 0.0
    flight = level_flight(Recording(np.arange(10.0), field_nT, accel_m_s2=accel), Reference(48_104.0), field_nT)
    assert flight.source == "the accelerometer"
    assert np.degrees(flight.dip_rad) == pytest.approx(np.degrees(np.arctan2(45.0, 17.0)))
