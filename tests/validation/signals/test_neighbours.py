"""A course by its neighbours: exact for a cubic, free of a sample's own error, and no loop for an attitude's noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.library.candidates import propose_candidates
from recordings import Recording
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import FIELD_ENU_NT, problem, recording
from validation.signals.neighbours import as_iron_sees, by_neighbours

LOOP = next(one for one in EFFECTS if one.continuous and not one.traits.correlates_noise)
FAR = np.full(3, np.inf)


def test_a_cubic_is_read_from_its_neighbours_as_it_is_at_uneven_times() -> None:
    rng = np.random.default_rng(0)
    time_s = np.arange(50) * 0.1 + rng.uniform(-0.02, 0.02, 50)
    cubic = np.polynomial.polynomial.polyval(time_s, rng.normal(size=(4, 3))).T
    assert by_neighbours(cubic, time_s, FAR) == pytest.approx(cubic, abs=1e-9)


def test_a_sample_s_own_error_has_no_part_in_it_where_the_signal_bends_slowly() -> None:
    time_s = np.arange(20) / 10.0
    signal = np.zeros((20, 3))
    signal[10, 1] = 4.0
    read = by_neighbours(signal, time_s, np.full(3, 5.0))
    assert read[10, 1] == 0.0
    assert read[[8, 9, 11, 12], 1] == pytest.approx(np.array([-4.0, 16.0, 16.0, -4.0]) / 6)
    assert (by_neighbours(signal, time_s, np.full(3, 2.0))[10] == signal[10]).all()


def test_two_samples_at_one_time_stay_as_they_are_and_so_does_a_short_series() -> None:
    time_s = np.array([0.0, 0.1, 0.1, 0.2, 0.3, 0.4, 0.5])
    signal = np.random.default_rng(1).normal(size=(7, 3))
    read = by_neighbours(signal, time_s, FAR)
    assert np.isfinite(read).all()
    assert (read[3] == signal[3]).all()
    assert (by_neighbours(signal[:4], time_s[:4], FAR) == signal[:4]).all()


def test_what_is_linear_in_the_course_is_what_the_base_takes_up() -> None:
    """A loop that never closes is the course itself, and nothing beside the iron."""
    rng = np.random.default_rng(2)
    signal = 1e4 * rng.normal(size=(12_000, 3))
    read = signal + rng.normal(size=(12_000, 3))
    columns = np.stack([read @ rng.normal(size=(3, 3)) + 7.0 for _ in range(2)], axis=2)
    seen = as_iron_sees(columns, read, signal).reshape(12_000, -1)
    base = np.column_stack([signal, np.ones(12_000)])
    assert np.abs(seen - base @ np.linalg.lstsq(base, seen, rcond=None)[0]).max() < 1e-6


def _with_rests(error_deg: float, seed: int) -> Recording:
    """Ten seconds of turning and ten of rest in turn, an attitude with a white error, and no gyro."""
    given = recording(seed=seed)
    gone_s = np.minimum(given.time_s % 20, 10) + given.time_s // 20 * 10
    turn = Rotation.from_euler(
        "ZYX", np.column_stack([0.13 * gone_s, 0.5 * np.sin(0.17 * gone_s), 0.6 * np.sin(0.11 * gone_s)])
    )
    rng = np.random.default_rng(seed)
    error = Rotation.from_rotvec(np.radians(error_deg) * rng.normal(size=(len(given), 3)))
    mag_nT = turn.inv().apply(FIELD_ENU_NT) + 2 * rng.normal(size=(len(given), 3))
    return replace(given, mag_nT=mag_nT, att_q=(turn * error).as_quat()[:, [3, 0, 1, 2]])


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("error_deg", [0.01, 0.05])
def test_a_narrow_loop_does_not_explain_the_attitude_s_own_noise(error_deg: float, seed: int) -> None:
    """By the samples as they are it does, with 11 to 69 nats: inside a loop it is the noise itself."""
    posed = problem(_with_rests(error_deg, seed))
    found = judge_settings(Baseline.of(posed), [propose_candidates(posed)[LOOP.name][0]])
    assert found is not None
    assert found.nats < posed.policy.apart
