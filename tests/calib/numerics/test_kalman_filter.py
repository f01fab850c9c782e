"""The compiled Kalman filter: the same numbers as filterpy's, over a run."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.kalman import STEADY, NoiseRule, filtered

RISING = NoiseRule(np.linspace(0.9, 1.1, 21), 0.5, 20.0, 10, 1e-3)


def run(engine: str, rule: NoiseRule, n: int = 300):  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(0)
    H, truth = rng.normal(size=(n, 3, 8)), rng.normal(size=8)
    y = H @ truth + rng.normal(0.0, 0.3, (n, 3))
    Q = 1e-6 * np.eye(8)
    return filtered(y, H, np.zeros(8), 10.0 * np.eye(8), Q, 0.1, rule, engine)  # type: ignore[arg-type]


@pytest.mark.parametrize("rule", [STEADY, RISING])
def test_compiled_filter_is_filterpys(rule: NoiseRule) -> None:
    for ours, filterpys in zip(run("compiled", rule), run("filterpy", rule), strict=True):
        np.testing.assert_allclose(ours, filterpys, rtol=1e-10, atol=1e-10)


def test_noise_follows_the_innovations_from_a_full_window_on() -> None:
    noise = run("compiled", RISING).noise
    assert (noise[:10] == 0.1).all()
    assert noise[10] != 0.1
    assert noise[-1] < 0.1 * 1.1**290


def test_ratio_is_taken_over_the_last_innovations_alone() -> None:
    """R from the innovations of the run itself, summed afresh for each sample."""
    steps = run("compiled", RISING)
    squares = (steps.innovation**2).sum(axis=1)
    for k in range(10, 299):
        ratio = squares[k - 9 : k + 1].mean() / steps.predicted[k]
        place = int(np.clip(np.rint((ratio - RISING.low) * RISING.per_ratio), 0, 20))
        assert steps.noise[k + 1] == pytest.approx(max(steps.noise[k] * RISING.factors[place], RISING.floor))


def test_steady_noise_stays() -> None:
    assert (run("compiled", STEADY).noise == 0.1).all()


def test_a_state_that_stays_is_that_of_least_squares_with_the_prior() -> None:
    """H of columns from 1 to 1e5 and a prior that weighs nothing beside them: P H H^T / R reaches 1e12."""
    rng = np.random.default_rng(0)
    H = rng.normal(size=(400, 3, 8)) * np.logspace(0, 5, 8)
    y = H @ np.ones(8) + rng.normal(0.0, 1.0, (400, 3))
    steps = filtered(y, H, np.zeros(8), 100.0 * np.eye(8), np.zeros((8, 8)), 1.0)
    rows = np.concatenate((np.eye(8) / 10.0, H.reshape(-1, 8)))
    size = np.linalg.norm(rows, axis=0)
    inverse = np.linalg.pinv(rows / size) / size[:, None]
    std = np.linalg.norm(inverse, axis=1)
    found = inverse @ np.concatenate((np.zeros(8), y.ravel()))
    np.testing.assert_allclose((steps.state[-1] - found) / std, 0.0, atol=1e-4)
    np.testing.assert_allclose(
        steps.covariance / np.outer(std, std), inverse @ inverse.T / np.outer(std, std), atol=1e-3
    )
