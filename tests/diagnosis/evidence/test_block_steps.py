"""The likelihood of steps between block means equals that of the dense covariance of known processes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import brentq
from scipy.stats import chi2, multivariate_normal

from diagnosis.evidence.slow_noise import Steps, is_random
from diagnosis.policy import STANDARD
from scenarios.arrays import Array

STEP_S, N = 0.1, 6000


def _walk_density(f: Array) -> Array:
    """One-sided density of a random walk of one unit over the root of a second."""
    return 1 / (2 * np.pi**2 * f**2)


def _steps(seed: int, white: float, walk: float) -> Steps:
    rng = np.random.default_rng([seed, 9])
    noise = white * rng.normal(size=(N, 1)) + np.cumsum(walk * np.sqrt(STEP_S) * rng.normal(size=(N, 1)), axis=0)
    return Steps.of(noise, STEP_S, STANDARD)


def test_the_correlation_of_white_noises_steps_is_two_and_minus_one() -> None:
    """Means of m samples of variance s^2: r_0 = 2 s^2 / m, r_1 = -s^2 / m, else nothing."""
    steps = _steps(0, 1.0, 0.0)
    m = steps.block_s / STEP_S
    r = steps.correlation(lambda f: np.full(len(f), 2 * STEP_S))
    assert r[:4] * m == pytest.approx([2.0, -1.0, 0.0, 0.0], abs=0.08)


def test_the_correlation_of_a_walks_steps_is_two_thirds_and_a_sixth() -> None:
    """Means of a walk over T: r_0 = 2/3 q^2 T, r_1 = q^2 T / 6."""
    steps = _steps(0, 1.0, 0.0)
    r = steps.correlation(_walk_density)
    assert r[:4] / steps.block_s == pytest.approx([2 / 3, 1 / 6, 0.0, 0.0], abs=0.02)


@pytest.mark.parametrize("walk", [0.0, 0.3])
def test_the_likelihood_is_that_of_the_dense_covariance(walk: float) -> None:
    steps = _steps(1, 1.0, walk)
    score, (size,), z = steps.fit(2 * STEP_S, _walk_density)
    row = steps.correlation(lambda f: 2 * STEP_S + size * _walk_density(f))
    dense = multivariate_normal(cov=toeplitz(row)).logpdf(steps.values[:, 0])
    assert score == pytest.approx(dense + len(steps.values) * np.log(2 * np.pi) / 2, rel=1e-6)
    assert z.std() == pytest.approx(1.0, abs=0.2)


def test_the_size_of_a_walk_is_found() -> None:
    sizes = [np.sqrt(_steps(seed, 1.0, 0.3).fit(2 * STEP_S, _walk_density)[1][0]) for seed in range(3)]
    assert np.mean(sizes) == pytest.approx(0.3, rel=0.15)


def test_a_walk_is_more_likely_than_white_noise_where_it_is_one() -> None:
    for walk, gains in ((0.3, True), (0.0, False)):
        steps = _steps(2, 1.0, walk)
        gain = steps.fit(2 * STEP_S, _walk_density)[0] - steps.fit(2 * STEP_S, None)[0]
        assert (gain > STANDARD.apart) == gains


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


@pytest.mark.parametrize(("n", "block_s"), [(10_000, 5.0), (1_000, 2.5), (100_000, 25.0)])
def test_steps_are_of_five_seconds_but_neither_few_nor_too_many(n: int, block_s: float) -> None:
    """From 40 to 400 of them."""
    noise = np.random.default_rng(0).normal(size=(n, 1))
    assert Steps.of(noise, STEP_S, STANDARD).block_s == pytest.approx(block_s, rel=0.03)
