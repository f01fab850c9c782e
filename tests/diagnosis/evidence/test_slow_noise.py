"""Slow noises of known size are told by name; errors of the attitude and driven gaps are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from diagnosis.evidence.along_field import is_attitude_error, within_stated_errors
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.slow_noise import find_slow_noise, is_earth_frame_noise, is_random
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS
from sim.effects.noise import GaussMarkovNoise
from tests.diagnosis.synthetic import NOISE_NT, problem, recording
from validation.signals.bands import Bands, hann

SLOW = [effect.name for effect in EFFECTS if effect.traits.spectrum is not None]
SIZES = dict.fromkeys(SLOW, 0.5) | {"gauss_markov_noise": 2.0}
SCALE_FREE = [name for name in SLOW if not BY_NAME[name].search]
"""Noises without a time of their own, which show as what they are at the slowest frequencies alone."""

BANDS = (STANDARD.first_line, STANDARD.bands)


def _hidden(name: str, seed: int = 0) -> LinearProblem:
    level = BY_NAME[name].with_role("level")
    return problem(hidden={name: {level: [SIZES[name]] * 3}}, seed=seed)


def _left(posed: LinearProblem) -> Array:
    return Baseline.of(posed).residual()


def _turned(error_deg: float) -> LinearProblem:
    """A recording whose attitude wanders."""
    given = recording()
    rng = np.random.default_rng(4)
    walk = np.cumsum(rng.normal(size=(len(given), 3)), axis=0)
    walk *= np.radians(error_deg) / walk.std()
    assert given.att_q is not None
    q = (Rotation.from_quat(given.att_q, scalar_first=True) * Rotation.from_rotvec(walk)).as_quat(scalar_first=True)
    return problem(replace(given, att_q=q, gyro_rad_s=None))


@pytest.mark.parametrize("name", SLOW)
def test_a_slow_noise_is_told_with_its_size(name: str) -> None:
    posed = _hidden(name)
    found = find_slow_noise(posed, _left(posed))
    assert found is not None
    assert name in (found.effect.name, *found.alternatives)
    if found.effect.name == name:
        level = BY_NAME[name].with_role("level")
        assert level is not None
        assert np.mean(getattr(found.effect, level)) == pytest.approx(SIZES[name], rel=0.3)


def test_a_walk_far_from_zero_is_told_beside_samples_that_are_left_out() -> None:
    """The samples left out are unknown: as zeros they would be jumps of a hundred times the noise."""
    walking = problem(hidden={"offset_random_walk": {"std_nT_sqrt_s": [60.0] * 3}})
    posed = walking.without(np.arange(len(walking.recording)) % 2000 < 15)
    found = find_slow_noise(posed, _left(posed))
    assert found is not None
    assert found.effect.name == "offset_random_walk"


@pytest.mark.parametrize("correlation_time_s", [3.0, 10.0])
def test_a_correlation_time_is_told(correlation_time_s: float) -> None:
    """Of an autoregression made here, beside the white noise of the recording."""
    given, decay = recording(8000), float(np.exp(-0.1 / correlation_time_s))
    kicks = np.random.default_rng(3).normal(size=(12_000, 3)) * np.sqrt(1 - decay**2)
    course_nT = 12.0 * lfilter([1.0], [1.0, -decay], kicks, axis=0)[4000:]
    posed = problem(replace(given, mag_nT=given.mag_nT + course_nT))
    found = find_slow_noise(posed, _left(posed))
    assert found is not None
    assert isinstance(found.effect, GaussMarkovNoise)
    assert found.effect.correlation_time_s == pytest.approx(correlation_time_s, rel=0.3)
    assert np.mean(found.effect.std_nT) == pytest.approx(12.0, rel=0.2)


@pytest.mark.parametrize(("part", "told"), [(1.0, True), (0.2, False)])
@pytest.mark.parametrize("name", SCALE_FREE)
def test_a_small_slow_noise_does_not_show_its_nature(name: str, part: float, told: bool) -> None:
    """It stands out of the white noise at too few frequencies."""
    level = BY_NAME[name].with_role("level")
    posed = problem(hidden={name: {level: [part * SIZES[name]] * 3}})
    found = find_slow_noise(posed, _left(posed))
    assert (found is not None and found.identified) == told


def test_white_noise_is_no_slow_one() -> None:
    posed = problem()
    assert find_slow_noise(posed, _left(posed)) is None


def test_an_error_of_the_attitude_has_nothing_along_the_field_and_is_no_noise() -> None:
    posed = _turned(0.05)
    assert is_attitude_error(posed, _left(posed))
    assert find_slow_noise(posed, _left(posed)) is None
    assert is_attitude_error(replace(posed, policy=replace(STANDARD, least_along_field=0.02)), _left(posed))


@pytest.mark.parametrize(("least", "told"), [(0.25, False), (0.5, True)])
def test_white_noise_has_a_third_of_its_power_along_the_field(least: float, told: bool) -> None:
    posed = problem(policy=replace(STANDARD, least_along_field=least))
    assert is_attitude_error(posed, np.random.default_rng(0).normal(size=(4000, 3))) is told


def test_a_gap_that_goes_with_a_channel_is_no_wander() -> None:
    given = recording()
    assert given.pos_enu_m is not None
    driven = replace(given, mag_nT=given.mag_nT + 0.02 * given.pos_enu_m[:, :1] ** 2 * np.array([1.0, -0.5, 0.5]))
    posed = problem(driven)
    assert find_slow_noise(posed, _left(posed)) is None


@pytest.mark.parametrize("of_the_field", [True, False])
def test_slow_noise_turns_with_the_sensor_and_a_field_that_walks_does_not(of_the_field: bool) -> None:
    """The same walk along the earth's axes and along the sensor's."""
    given = recording()
    walk_nT = np.cumsum(np.random.default_rng(6).normal(size=(len(given), 3)), axis=0) * 0.05
    assert given.att_q is not None
    turn = Rotation.from_quat(given.att_q, scalar_first=True).inv()
    posed = problem(replace(given, mag_nT=given.mag_nT + (turn.apply(walk_nT) if of_the_field else walk_nT)))
    assert is_earth_frame_noise(posed, _left(posed)) is of_the_field
    assert (find_slow_noise(posed, _left(posed)) is None) is of_the_field


def test_slow_noise_that_hides_the_white_one_has_a_level() -> None:
    """Flicker of three sigma that is white nowhere in the band: the best level underflows to nothing."""
    bands = Bands.of(np.random.default_rng(5).normal(size=(20_000, 3)), 0.1, *BANDS)
    steep = 1 / bands.f**3
    _, level, _ = replace(bands, density=steep[None]).fit(steep)
    assert level >= 2e-5


def test_what_the_model_states_of_its_attitude_is_no_gap_and_more_is() -> None:
    posed = _turned(0.01)
    left = _left(posed)
    stated = replace(posed, attitude_std_rad=np.radians(0.01))
    less = replace(posed, attitude_std_rad=np.radians(0.002))
    assert not within_stated_errors(posed, left)
    assert within_stated_errors(stated, left)
    assert not within_stated_errors(less, left)


def test_a_stated_attitude_error_excuses_nothing_along_the_field() -> None:
    posed = replace(_hidden(SLOW[0]), attitude_std_rad=np.radians(1.0))
    assert not within_stated_errors(posed, _left(posed))


@pytest.mark.parametrize("name", SLOW)
def test_a_wander_that_the_model_has_is_stated(name: str) -> None:
    level = BY_NAME[name].with_role("level")
    assert level is not None
    posed = _hidden(name)
    known = replace(posed, effects=(BY_NAME[name](**{level: (SIZES[name],) * 3}),))
    small = replace(posed, effects=(BY_NAME[name](**{level: (SIZES[name] / 10,) * 3}),))
    assert within_stated_errors(known, _left(posed))
    assert not within_stated_errors(small, _left(posed))
    assert pytest.approx(float(posed.sigma_nT.mean()), rel=0.1) == NOISE_NT


@pytest.mark.parametrize(("share", "turns"), [(0.11, True), (0.14, False)])
def test_an_error_of_the_attitude_has_an_eighth_along_the_field_at_most(share: float, turns: bool) -> None:
    posed = problem(n=400)
    along = posed.state.field_nT @ posed.turn.T
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, [0.3, 0.4, 0.5])
    across = across / np.linalg.norm(across, axis=1, keepdims=True)
    off_nT = np.sqrt(share) * along + np.sqrt(1 - share) * across
    assert is_attitude_error(posed, off_nT / posed.sigma_nT) is turns


def test_a_spectrum_of_another_shape_is_no_slow_noise() -> None:
    """A random course of two minutes and one of two seconds, of one size: the library has the shape of neither sum."""
    course = np.random.default_rng(7).normal(size=(4000 + 1200, 3))
    long, short = (np.apply_along_axis(np.convolve, 0, course, hann(n)[:, 0], "same")[600:4600] for n in (1200, 20))
    posed = problem(noise_nT=0.1)
    residual = np.random.default_rng(8).normal(size=(4000, 3)) + long / long.std() + short
    assert find_slow_noise(posed, residual) is None


def test_random_innovations_pass_and_jumps_courses_and_swings_do_not() -> None:
    rng = np.random.default_rng(3)
    passed = [is_random(rng.normal(size=(200, 3)), STANDARD) for _ in range(200)]
    assert np.mean(passed) > 0.97
    z = rng.normal(size=(200, 3))
    jump, course = z.copy(), z.copy()
    jump[100] += 9.0
    course[50:114] += 1.0
    swing = z + 1.5 * np.sin(2 * np.pi * np.arange(200) / 12)[:, None]
    assert not any(is_random(one, STANDARD) for one in (jump, course, swing))


def _drawn(jump: float = 0.0, follows: float = 0.0) -> Array:
    """Innovations (n, 1) of which one stands out, or each follows the one before in part."""
    z = np.random.default_rng(1).normal(size=(401, 1))
    z = z[1:] + follows * z[:-1]
    z[np.abs(z) > 3] = 0.0
    z[200] = jump * np.delete(z, 200).std() if jump else z[200]
    return z


@pytest.mark.parametrize(("jump", "random"), [(4.6, True), (5.6, False)])
def test_a_lone_jump_of_five_sigma_is_none_that_chance_draws(jump: float, random: bool) -> None:
    assert is_random(_drawn(jump), STANDARD) is random


@pytest.mark.parametrize(("chance", "random"), [(2e-3, True), (5e-4, False)])
def test_innovations_correlate_by_chance_once_in_a_thousand(chance: float, random: bool) -> None:
    """Over eight lags, each a square of unit mean."""

    def odds(follows: float) -> float:
        z = _drawn(follows=follows)[:, 0]
        z /= z.std()
        squares = sum(float(z[lag:] @ z[:-lag]) ** 2 / (len(z) - lag) for lag in range(1, 9))
        return float(chi2.sf(squares, 8))

    assert is_random(_drawn(follows=float(brentq(lambda x: odds(x) - chance, 0.05, 0.6))), STANDARD) is random


def test_a_constant_is_in_no_band_and_a_wave_of_two_periods_is() -> None:
    """The window carries a mean into the first line."""
    t = np.arange(4000.0) / 4000
    slow = 1e3 * np.sin(4 * np.pi * t)
    constant, wave = (Bands.of(one[:, None], 0.1, *BANDS).power.max() for one in (0 * t + 1e3, slow))
    assert constant < 1e-6 * wave


def test_pulses_that_come_at_random_and_die_away_are_no_noise_of_the_sensor() -> None:
    """Their spectrum is a Gauss-Markov process', their tails are not."""
    given, rng = recording(), np.random.default_rng(0)
    drive = np.zeros((len(given), 3))
    drive[rng.choice(len(given), 25, replace=False)] = 12 * NOISE_NT * rng.normal(size=(25, 3))
    decay = 1 - float(np.median(np.diff(given.time_s))) / 4.0
    posed = problem(replace(given, mag_nT=given.mag_nT + lfilter([1.0], [1.0, -decay], drive, axis=0)))
    assert find_slow_noise(posed, _left(posed)) is None
    assert find_slow_noise(replace(posed, wrong_values=True), _left(posed)) is not None
