"""Channels lose their own noise, and nothing that the magnetometer sees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import smoothed
from diagnosis.problem.vector import vector_problem
from recordings.channels import TEMPERATURE
from tests.diagnosis.synthetic import FIELD_ENU_NT, problem, recording


def _course(n: int = 6000) -> np.ndarray:
    t = np.arange(n) / 10.0
    return np.asarray(15 + 3 * np.exp(-t / 200) + np.sin(0.05 * t) + 2.0 * (t > 300))


def test_a_smoothed_series_is_nearer_to_the_truth_than_the_measured_one() -> None:
    truth = _course()
    noise = 0.2 * np.random.default_rng(3).normal(size=len(truth))
    left = smoothed(truth + noise, STANDARD.bands) - truth
    assert left.std() < 0.3 * noise.std()
    assert np.abs(left).max() < 1.5  # a step is rounded off, and does not move
    assert smoothed(truth + noise, STANDARD.bands).mean() == pytest.approx((truth + noise).mean())


@pytest.mark.parametrize("series", [np.zeros(500), np.arange(500.0), np.arange(500.0) ** 2])
def test_what_has_no_noise_stays(series: np.ndarray) -> None:
    np.testing.assert_allclose(smoothed(series, STANDARD.bands), series, atol=1e-6 * max(1.0, np.ptp(series)))


@pytest.mark.parametrize("seen", [False, True])
def test_what_the_magnetometer_sees_is_no_noise(seen: bool) -> None:
    made = recording()
    assert made.temperature_degC is not None
    spread = 0.1 * np.random.default_rng(4).normal(size=len(made))
    warm = made.temperature_degC + spread
    mag_nT = made.mag_nT + (20.0 * spread[:, None] if seen else 0.0)
    posed = problem(replace(made, temperature_degC=warm, mag_nT=mag_nT))
    raw = vector_problem(posed.recording, FIELD_ENU_NT, posed.known)
    assert np.array_equal(raw.state.channel(TEMPERATURE), warm)
    left = posed.state.channel(TEMPERATURE) - warm
    assert (left.std() == 0) if seen else (left + spread).std() < 0.3 * spread.std()
