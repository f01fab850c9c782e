"""Columns that are slower than the rows, by a known factor."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import RATE_HZ, log_of, noise, one, still
from validation.inspection.finding import Finding
from validation.inspection.rates import interpolation_rows, rate_findings, stale

SAMPLES = 3000
TIME_S = np.arange(SAMPLES) / RATE_HZ


def findings(time_s: Array, **columns: Array) -> list[Finding]:
    return rate_findings(log_of(time_s, noise(len(time_s), 5.0) + 20_000.0, **columns))


def test_a_held_column_has_its_own_rate() -> None:
    """5 Hz among rows of 50 Hz."""
    held = np.repeat(np.random.default_rng(1).normal(20, 1, SAMPLES // 10), 10)
    found = one(findings(TIME_S, temperature_degC=held), "rate_temperature_degC")
    assert found.value == pytest.approx(5.0, rel=0.01)
    assert "held, 5" in found.text


def test_an_interpolated_column_has_the_rate_of_its_kinks() -> None:
    gyro = noise(SAMPLES // 20 + 1, 1.0, seed=2)
    whole = np.column_stack([np.interp(np.arange(SAMPLES) / 20, np.arange(len(gyro)), column) for column in gyro.T])
    assert interpolation_rows(whole) == pytest.approx(20, rel=0.05)
    assert one(findings(TIME_S, gyro=whole), "rate_gyro").value == pytest.approx(RATE_HZ / 20, rel=0.05)
    assert interpolation_rows(noise(SAMPLES, 1.0)) is None
    assert interpolation_rows(np.zeros((SAMPLES, 3))) is None


def test_sparse_constant_and_empty_columns() -> None:
    sparse = np.full(SAMPLES, np.nan)
    sparse[::10] = np.random.default_rng(3).normal(0, 1, SAMPLES // 10)
    switched = np.where(TIME_S > 30, 1.0, 0.0)
    found = findings(TIME_S, a=sparse, b=np.full(SAMPLES, 7.0), c=np.full(SAMPLES, np.nan), d=switched)
    assert one(found, "rate_a").value == pytest.approx(5.0, rel=0.01)
    assert one(found, "rate_b").text == "B: one constant value."
    assert (one(found, "rate_c").value, one(found, "rate_c").level) == (0.0, "warning")
    assert "1 change," in one(found, "rate_d").text
    assert one(found, "full_rate").value == ["magnetometer"]


def test_a_coarse_converter_at_rest_is_not_a_slower_sensor() -> None:
    """Rows repeat by chance when the noise is below the step, whether next to each other or far apart."""
    coarse = 100 * np.round((still(SAMPLES)[1] + noise(SAMPLES, 20.0)) / 100)
    assert not stale(coarse)
    assert stale(np.repeat(noise(SAMPLES // 4, 20.0), 4, axis=0))
    assert not stale(noise(SAMPLES, 20.0))
    assert not stale(np.zeros((10, 3)))


def test_the_rate_of_a_channel_that_no_calibration_needs_is_no_note() -> None:
    held = np.repeat(np.random.default_rng(1).normal(20, 1, SAMPLES // 10), 10)
    found = findings(TIME_S, temperature_degC=held, pressure_hPa=held)
    assert one(found, "rate_temperature_degC").level == "note"
    assert one(found, "rate_pressure_hPa").level == "ok"
    assert one(found, "rate_pressure_hPa").value == pytest.approx(5.0, rel=0.01)
