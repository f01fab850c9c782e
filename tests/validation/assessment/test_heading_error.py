"""Heading errors against analytic ones, in a frame of the test's own."""

from __future__ import annotations

import numpy as np
import pytest

from calib import Calibration, Reference, Status
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.heading_error import heading_error
from validation.assessment.level_flight import LevelFlight, level_flight
from validation.assessment.posterior import SensorDraws

FLIGHT = LevelFlight(50_000.0, float(np.radians(60.0)), "the field vector")


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
