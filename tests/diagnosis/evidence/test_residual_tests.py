"""White noise passes the tests at the rate that the policy states; slow waves, tones and tails do not."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.residual_tests import ResidualTests, missing_white_noise, run_residual_tests
from diagnosis.policy import STANDARD, Policy
from recordings.channels import current_name
from scenarios.arrays import Array
from sim.effects.currents import MotorCurrent
from sim.effects.electronics import Quantisation
from sim.effects.noise import WhiteNoise
from tests.diagnosis.synthetic import problem, recording

N, STEP_S = 20_000, 0.02
TIME_S = STEP_S * np.arange(N)


def _tests(residual: Array, policy: Policy = STANDARD, memory: int = 1) -> ResidualTests:
    return run_residual_tests(residual, np.ones(len(residual)), TIME_S, 0, policy, memory)


def _excess(residual: Array, time_s: Array = TIME_S, fitted: int = 0) -> dict[float, float]:
    """The variance of means over white noise's, by the length of every mean that is tested."""
    told = run_residual_tests(residual, np.ones(len(residual)), time_s, fitted, Policy(test_alarm=10.0)).why
    found = (re.match(r"means over ([\d.]+) s vary ([\d.]+) times", line) for line in told)
    return {float(one[1]): float(one[2]) for one in found if one}


def _white(seed: int) -> Array:
    return np.random.default_rng([seed, 5]).normal(size=(N, 3))


def test_white_noise_is_clean() -> None:
    """At most 0.1 % for means and as little for tones and tails: none or one of 40."""
    assert sum(not _tests(_white(seed)).clean for seed in range(40)) <= 1


def test_an_alarm_of_a_half_is_given_to_about_half() -> None:
    loose = Policy(test_alarm=0.5)
    alarms = sum(any(w.startswith("means") for w in _tests(_white(seed), loose).why) for seed in range(30))
    assert 0.15 * 30 < alarms < 0.65 * 30


def test_the_excess_of_means_is_one_for_white_noise_and_that_of_a_wave_for_a_wave() -> None:
    excess = _excess(_white(0))
    assert set(excess) == set(STANDARD.mean_lengths_s)
    assert list(excess.values()) == pytest.approx([1.0] * 3, abs=0.25)
    size, length = 0.1, round(5.0 / STEP_S)
    wave = size * np.sqrt(2) * np.sin(2 * np.pi * 0.004 * STEP_S * np.arange(N))[:, None]
    assert _excess(_white(0) + wave)[5.0] == pytest.approx(1 + length * size**2, rel=0.15)


@pytest.mark.parametrize(
    ("added", "word"),
    [
        (lambda t: 0.1 * np.sin(2 * np.pi * 0.02 * t), "means"),
        (lambda t: 0.15 * np.sin(2 * np.pi * 7.3 * t), "tones at 7.3"),
        (lambda t: np.where(np.arange(len(t)) % 1000 == 0, 12.0, 0.0), "heavy tails"),
    ],
)
def test_what_is_left_is_told_by_its_word(added, word) -> None:  # type: ignore[no-untyped-def]
    tests = _tests(_white(1) + added(STEP_S * np.arange(N))[:, None])
    assert not tests.clean
    assert any(line.startswith(word) for line in tests.why)


def test_noise_behind_a_filter_is_clean_where_its_memory_is_known() -> None:
    smooth = np.apply_along_axis(lambda v: np.convolve(v, np.ones(3) / np.sqrt(3), "same"), 0, _white(2))
    assert any(line.startswith("means") for line in _tests(smooth).why)
    assert not any(line.startswith("means") for line in _tests(smooth, memory=STANDARD.filter_memory).why)


def test_samples_left_out_do_not_count() -> None:
    residual, usable = _white(3), np.ones(N)
    usable[3000:9000] = 0.0
    residual[usable == 0] = 0.0
    tests = run_residual_tests(residual, usable, TIME_S, 12, STANDARD)
    assert not any(line.startswith(("means", "heavy")) for line in tests.why)


def test_a_slow_log_is_tested_too() -> None:
    """At 15 s between samples a wave of two hours is neither clean nor untested."""
    time_s = np.cumsum(np.random.default_rng(7).uniform(8.0, 22.0, 3000))
    white = _white(4)[: len(time_s)]
    wave = 0.5 * np.sin(2 * np.pi * time_s / 7200.0)[:, None]
    calm = run_residual_tests(white, np.ones(len(white)), time_s, 0, STANDARD)
    assert calm.clean
    assert list(_excess(white, time_s)) == pytest.approx([75, 375, 1500], rel=0.02)
    assert not run_residual_tests(white + wave, np.ones(len(white)), time_s, 0, STANDARD).clean


def test_means_are_over_time_and_not_over_bursts() -> None:
    """Ten samples at 50 Hz each minute with an offset of each burst, the next with its negative: seen over a second."""
    time_s = (60.0 * np.arange(400)[:, None] + 0.02 * np.arange(10)).ravel()
    pairs = np.random.default_rng(8).normal(size=(200, 1, 3)) * np.array([[1.0], [-1.0]])
    offsets = np.repeat(pairs.reshape(400, 3), 10, axis=0)
    excess = _excess(_white(5)[:4000] + offsets, time_s)
    assert excess[1.0] == pytest.approx((1 + 10 * 1.0) / 2, rel=0.1)  # of a variance of 2


def test_what_was_fitted_counts_in_the_noise_and_few_means_are_not_tested() -> None:
    wave = np.sin(2 * np.pi * 0.004 * TIME_S)[:, None]
    plain, fitted = (_excess(_white(3) + wave, fitted=k) for k in (0, N))
    assert list(fitted.values()) == pytest.approx([2 / 3 * one for one in plain.values()], rel=0.01)
    assert _excess(_white(3)[:900], TIME_S[:900]) == {}


def test_rows_left_out_in_a_pattern_make_no_tones_of_a_slow_rest() -> None:
    residual = 5 * np.cumsum(_white(6), axis=0) / np.sqrt(N)
    usable = np.ones(N)
    usable[np.arange(N) % 7 > 4] = 0.0
    left = (residual + 0.1 * _white(7)) * usable[:, None]
    tests = run_residual_tests(left, usable, TIME_S, 0, STANDARD)
    assert not any(line.startswith("tones") for line in tests.why)


@pytest.mark.parametrize(("louder", "heavy"), [(0.19, False), (0.3, True)])
def test_tails_are_heavy_beyond_a_tenth_and_what_a_long_record_scatters(louder: float, heavy: bool) -> None:
    """Louder and quieter by a share every other sample, normal noise has a kurtosis of three of its squares."""
    sizes = np.sqrt(1 + louder * np.where(np.arange(3 * N) % 2, 1, -1))
    residual = np.random.default_rng(0).normal(size=(3 * N, 3)) * sizes[:, None]
    tests = run_residual_tests(residual, np.ones(3 * N), STEP_S * np.arange(3 * N), 0, STANDARD)
    assert any(line.startswith("heavy tails") for line in tests.why) is heavy


@pytest.mark.parametrize(("chance", "alarm"), [(6e-4, False), (2e-4, True)])
def test_means_are_no_white_noises_where_that_has_them_once_in_three_thousand(chance: float, alarm: bool) -> None:
    """Thirty means of a second of three axes, one length of three: a thousandth in all."""
    rng, m = np.random.default_rng(0), 50
    squared = chi2.isf(chance, 90) / 90 / m
    noise = rng.normal(size=(30, m, 3))
    noise -= noise.mean(axis=1, keepdims=True)
    noise *= np.sqrt((1 - squared) / (noise**2).mean(axis=(0, 1)))
    residual = (noise + np.sqrt(squared) * rng.choice([-1.0, 1.0], size=(30, 1, 3))).reshape(-1, 3)
    tests = run_residual_tests(residual, np.ones(1500), STEP_S * np.arange(1500), 0, STANDARD)
    assert set(_excess(residual, STEP_S * np.arange(1500))) == {1.0}
    assert any(line.startswith("means") for line in tests.why) is alarm


def test_more_white_noise_is_what_the_model_lacks() -> None:
    """sqrt(5^2 - 3^2) = 4; rounding to q has q^2 / 12 of its own."""
    posed = problem(noise_nT=5.0, model=(WhiteNoise((3.0, 3.0, 3.0)),))
    left = Baseline.of(posed).residual()
    found = missing_white_noise(posed, left, ())
    assert isinstance(found, WhiteNoise)
    assert found.std_nT == pytest.approx((4.0,) * 3, rel=0.06)
    assert missing_white_noise(posed, left, (Quantisation(float(np.sqrt(12 * 16))),)) is None
    assert missing_white_noise(problem(noise_nT=5.0, model=(WhiteNoise((4.9, 4.9, 4.9)),)), left, ()) is None
    assert missing_white_noise(problem(noise_nT=5.0), left, ()) is None


def test_the_noise_of_a_current_is_no_noise_of_the_magnetometer() -> None:
    """0.1 A of noise beside 50 nT/A are 5 nT, as of a field that the current does not follow so fast."""
    made = recording(noise_nT=5.0)
    noisy = made.current_A + 0.1 * np.random.default_rng(1).normal(size=made.current_A.shape)
    posed = problem(replace(made, current_A=noisy), model=(WhiteNoise((3.0, 3.0, 3.0)),))
    posed = replace(posed, state=replace(posed.state, channels={**posed.state.channels, current_name(1): noisy[:, 0]}))
    follows = MotorCurrent(gain_nT_A=(50.0, 50.0, 50.0), motor=1)
    left = Baseline.of(posed).residual()
    assert missing_white_noise(posed, left, (follows,)) is None
    assert missing_white_noise(posed, left, (replace(follows, gain_nT_A=(5.0, 5.0, 5.0)),)) is not None
