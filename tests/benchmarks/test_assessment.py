"""The logs of the assessment's bench are what they say, and its shares count what they name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.assessment.bench import Judged, area, rows_of, table
from benchmarks.assessment.catalogue_logs import DISTURB, WANDERING, catalogue_log
from benchmarks.assessment.logs import log_of
from calib import Calibration, Status
from calib.input_terms import InputTerm
from scenarios.arrays import Array
from sim.effects.iron import HardIron
from sim.effects.offsets import OffsetJump

GOOD = Judged(0, "ellipsoid", "ok", True, 0.1, 0.1, 0.5, True, "good", "high", (("yes", True), ("no", False)), ("a",))


def fit(offset_nT: Array, matrix: Array, *inputs: InputTerm) -> Calibration:
    return Calibration(name="test", status=Status("ok"), offset_nT=offset_nT, matrix=matrix, inputs=inputs)


def test_a_log_is_the_same_for_its_seed_and_another_for_the_next() -> None:
    assert np.array_equal(log_of(3).recording.mag_nT, log_of(3).recording.mag_nT)
    assert not np.array_equal(log_of(3).recording.mag_nT[:5], log_of(4).recording.mag_nT[:5])


@pytest.mark.parametrize("seed", range(4))
def test_the_true_calibration_of_a_sound_log_has_no_heading_error_and_leaves_the_noise(seed: int) -> None:
    log = log_of(seed, "")
    matrix = np.linalg.inv(log.soft)
    assert log.heading_rms_deg(fit(log.offset_nT, matrix)) < 1e-9
    strength = np.linalg.norm((log.recording.mag_nT - log.offset_nT) @ matrix.T, axis=1)
    assert np.std(strength) < 0.01 * np.linalg.norm(log.world_nT)


def test_an_offset_error_turns_the_heading_by_its_share_of_the_horizontal_field() -> None:
    log = replace(log_of(1, ""), soft=np.eye(3))
    level = float(np.hypot(*log.world_nT[:2]))
    error = log.heading_rms_deg(fit(log.offset_nT + np.array([0.01 * level, 0.0, 500.0]), np.eye(3)))
    assert error == pytest.approx(np.degrees(0.01) / np.sqrt(2.0), rel=0.01)


def test_a_simulated_logs_true_calibration_has_the_error_of_the_motors_alone_and_with_their_term_none() -> None:
    """Of quad-calibration: A g across the heading, times the current's rms change, in the horizontal field H."""
    log = next(one for seed in range(40) if (one := catalogue_log(seed, 35_000_000, "")).motion == "quad-calibration")
    level, gain_nT_A = log.level(), np.array([6.0, -4.0, 9.0])
    assert log.recording.current_A is not None
    current = log.recording.current_A.sum(axis=1)
    matrix = np.linalg.inv(level.soft)
    mean = next(one.offset_nT for one in log.run.effects[0] if isinstance(one, HardIron)) + gain_nT_A * current.mean()
    H = float(np.hypot(*log.run.field_enu_nT[:2]))
    expected = np.degrees(np.std(current) * np.hypot(*(matrix @ gain_nT_A)[:2]) / np.sqrt(2.0) / H)
    plain = level.heading_rms_deg(fit(mean, matrix), log.recording, turned=True)
    assert plain == pytest.approx(expected, rel=0.2)
    term = InputTerm("current_sum_A", gain_nT_A)
    taken_off = fit(mean - gain_nT_A * current.mean(), matrix, term)
    assert level.heading_rms_deg(taken_off, log.recording, turned=True) < 0.1 * plain


def test_a_wandering_offsets_mean_is_a_part_of_a_simulated_logs_offset() -> None:
    log = next(one for seed in range(40) if "jump" in (one := catalogue_log(seed, 35_000_000, "jump")).disturbances)
    late = log.recording.time_s >= next(one.time_s for one in log.run.effects[0] if isinstance(one, OffsetJump))
    step = np.array(next(one.step_nT for one in log.run.effects[0] if isinstance(one, OffsetJump)))
    still = replace(log, truth=replace(log.truth, effects={}))
    moved = log.level().measured_nT - still.level().measured_nT
    wandered = [field for name, field in log.truth.effects.items() if name in WANDERING and name != "offset_jump"]
    rest = np.sum(wandered, axis=0).mean(axis=0) if wandered else 0.0
    assert moved[0] == pytest.approx(step * late.mean() + rest, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", DISTURB)
def test_every_disturbance_makes_a_log(name: str) -> None:
    log = next(one for seed in range(60) if name in (one := catalogue_log(seed, 35_000_000, name)).disturbances)
    assert len(log.recording) > 100
    assert np.isfinite(log.level().measured_nT).all()


def test_a_wrong_yes_and_an_interval_that_misses_are_counted() -> None:
    missed = replace(GOOD, rank=0.99, inside=False, answers=(("yes", False), ("no", False)))
    figures = {row.what: row.value for row in rows_of([GOOD, missed])}
    assert figures["interval holds, at least"] == 0.5
    assert figures["wrong yes"] == 0.5
    assert figures["wrong no"] == 0.0
    assert figures["good told from bad, area"] is None
    assert any("0.500" in line for line in table([GOOD, missed]))


def test_the_area_is_the_probability_that_the_lower_is_lower() -> None:
    assert area([1.0, 2.0], [3.0]) == 1.0
    assert area([1.0, 3.0], [2.0, 3.0]) == pytest.approx(0.625)
    assert area([], [1.0]) is None
