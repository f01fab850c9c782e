"""The rest: its spectrum, its variances, and the filter that whitens it, against dense covariances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from diagnosis.evidence.noise_model import NoiseModel, ou_density, seen_density
from diagnosis.policy import STANDARD
from scenarios.arrays import Array
from validation.signals.bands import Bands


def process(rng: np.random.Generator, n: int, tau_rows: float, std: float) -> Array:
    """A sampled Ornstein-Uhlenbeck process (n,) by its recursion."""
    a = np.exp(-1 / tau_rows)
    drive = rng.normal(size=n) * std * np.sqrt(1 - a * a)
    drive[0] = rng.normal() * std
    return np.asarray(lfilter([1.0], [1.0, -a], drive))


def covariance(noise_model: NoiseModel, time_s: Array, a: int) -> Array:
    """Dense covariance (n, n) of an output."""
    apart = np.abs(time_s[:, None] - time_s)
    slow = sum(v * np.exp(-apart / tau) for v, tau in zip(noise_model.slow[a], noise_model.tau_s, strict=True))
    return np.asarray(noise_model.white[a] * np.eye(len(time_s)) + slow)


def test_the_filter_gives_the_likelihood_of_the_dense_covariance_gaps_included() -> None:
    rng = np.random.default_rng(0)
    time_s = np.cumsum(rng.uniform(0.5, 1.5, 80)) + np.where(np.arange(80) > 40, 30.0, 0.0)
    noise_model = NoiseModel(np.array([2.0, 40.0]), np.array([1.0, 0.3]), np.array([[0.5, 3.0], [0.0, 1.0]]))
    usable = (rng.random(80) > 0.2).astype(float)
    y = rng.normal(size=(80, 2, 1))
    z, ln_S = noise_model.whitened(time_s, usable, y)
    use = usable > 0
    for a in range(2):
        C = covariance(noise_model, time_s[use], a)
        values = y[use, a, 0]
        exact = np.linalg.slogdet(C)[1] + values @ np.linalg.solve(C, values)
        assert ln_S[:, a].sum() + (z[:, a, 0] ** 2).sum() == pytest.approx(exact, rel=1e-10)


def test_a_gain_that_has_settled_is_found_anew_where_the_steps_change() -> None:
    rng = np.random.default_rng(7)
    time_s = np.cumsum(np.repeat([0.5, 4.0], 120))
    noise_model, y = NoiseModel(np.array([3.0]), np.array([1.0]), np.array([[5.0]])), rng.normal(size=240)
    z, ln_S = noise_model.whitened(time_s, np.ones(240), y[:, None, None])
    C = covariance(noise_model, time_s, 0)
    assert (z**2).sum() == pytest.approx(y @ np.linalg.solve(C, y), rel=1e-10)
    assert ln_S.sum() == pytest.approx(np.linalg.slogdet(C)[1], rel=1e-10)


def test_whitening_is_linear_and_leaves_white_noise() -> None:
    rng = np.random.default_rng(1)
    y = np.stack([process(rng, 6000, 30.0, 2.0) + rng.normal(size=6000) for _ in range(3)], axis=1)
    noise_model = NoiseModel(np.array([30.0]), np.ones(3), np.full((3, 1), 4.0))
    time_s = np.arange(6000.0)
    both, _ = noise_model.whitened(time_s, np.ones(6000), np.stack([y, 2 * y], axis=2))
    z = both[:, :, 0]
    np.testing.assert_allclose(both[:, :, 1], 2 * z)
    assert z.var() == pytest.approx(1.0, abs=0.04)
    assert all(abs((z[k:] * z[:-k]).mean()) < 0.03 for k in (1, 2, 5, 30, 300))


def test_density_is_the_spectrum_of_the_recursion() -> None:
    rng = np.random.default_rng(2)
    power = np.mean([np.abs(np.fft.rfft(process(rng, 1024, 12.0, 1.0))) ** 2 / 1024 for _ in range(400)], axis=0)
    f = np.fft.rfftfreq(1024)
    expected = ou_density(f, np.array([12.0]), 1.0)[0]
    np.testing.assert_allclose(
        power[5:300].reshape(-1, 5).mean(axis=1), expected[5:300].reshape(-1, 5).mean(axis=1), rtol=0.15
    )


def test_variances_are_found_within_the_ladder() -> None:
    rng = np.random.default_rng(3)
    y = np.stack([process(rng, 8000, 40.0, 1.5) + rng.normal(size=8000), rng.normal(size=8000)], axis=1)
    noise_model = NoiseModel.of(Bands.of(y, 1.0, 1, STANDARD.bands), STANDARD)
    assert noise_model.white == pytest.approx([1.0, 1.0], rel=0.07)
    assert noise_model.slow[0].sum() == pytest.approx(1.5**2, rel=0.35)
    assert noise_model.slow[1].sum() < 0.1


@pytest.mark.parametrize("seed", [4, 5, 6])
@pytest.mark.parametrize("step", [0.05, 0.3])
def test_a_found_rest_is_as_likely_as_the_true_one(step: float, seed: int) -> None:
    """A random walk is no process of the ladder; its likelihood is."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(step * rng.normal(size=5000))
    y = (walk - walk.mean() + rng.normal(size=5000))[:, None]
    time_s, one = np.arange(5000.0), np.ones(5000)

    def likelihood(noise_model: NoiseModel) -> float:
        z, ln_S = noise_model.whitened(time_s, one, y[:, :, None])
        return -(ln_S.sum() + (z**2).sum()) / 2

    true = NoiseModel(np.array([1e6]), np.ones(1), np.full((1, 1), step**2 * 1e6 / 2))
    assert likelihood(NoiseModel.of(Bands.of(y, 1.0, 1, STANDARD.bands), STANDARD)) > likelihood(true) - 8
    assert likelihood(NoiseModel(np.ones(1), np.array([y.var()]), np.zeros((1, 1)))) < likelihood(true) - 100


def test_a_wander_seen_along_a_turning_direction_has_the_likelihood_of_its_dense_covariance() -> None:
    """Against the normal density with the covariance written down: white, one scalar process, one of three axes."""
    rng = np.random.default_rng(5)
    n, tau_s, slow, turning, noise = 120, np.array([3.0, 40.0]), np.array([[2.0, 0.0]]), np.array([0.0, 5.0]), 0.7
    time_s = np.cumsum(rng.uniform(0.5, 1.5, n))
    output_axes = rng.normal(size=(n, 3))
    output_axes /= np.linalg.norm(output_axes, axis=1, keepdims=True)
    apart = np.abs(time_s[:, None] - time_s)
    C = noise * np.eye(n) + 2.0 * np.exp(-apart / 3.0) + 5.0 * np.exp(-apart / 40.0) * (output_axes @ output_axes.T)
    y = np.linalg.cholesky(C) @ rng.normal(size=n)
    noise_model = NoiseModel(tau_s, np.array([noise]), slow, turning, output_axes[:, None])
    z, ln_S = noise_model.whitened(time_s, np.ones(n), y[:, None, None])
    assert (z**2).sum() == pytest.approx(y @ np.linalg.solve(C, y), rel=1e-9)
    assert ln_S.sum() == pytest.approx(np.linalg.slogdet(C)[1], rel=1e-9)


def test_two_outputs_see_one_wander() -> None:
    """Against the normal density of both: own noise and own slow process of each, and one of three axes that both see.

    The second sees the axes over a noise of its own; a fifth of the rows is not usable.
    """
    rng = np.random.default_rng(8)
    n, tau_s, white = 90, np.array([20.0, 7.0]), np.array([0.7, 3.0])
    slow, turning = np.array([[2.0, 0.0], [0.0, 4.0]]), np.array([0.0, 5.0])
    time_s, usable = np.cumsum(rng.uniform(0.5, 1.5, n)), (rng.random(n) > 0.2).astype(float)
    output_axes = rng.normal(size=(n, 2, 3))
    output_axes *= np.array([1.0, 0.3])[:, None] / np.linalg.norm(output_axes, axis=2, keepdims=True)
    apart, there = np.abs(time_s[:, None] - time_s), usable > 0
    seen = np.einsum("iac,jbc->aibj", output_axes, output_axes) * 5.0 * np.exp(-apart / 7.0)[None, :, None]
    for a, own in enumerate((2.0 * np.exp(-apart / 20.0), 4.0 * np.exp(-apart / 7.0))):
        seen[a, :, a] += own + white[a] * np.eye(n)
    C, y = seen[:, there][..., there].reshape(2 * there.sum(), -1), rng.normal(size=(n, 2))
    z, ln_S = NoiseModel(tau_s, white, slow, turning, output_axes).whitened(time_s, usable, y[:, :, None])
    values = y[there].T.ravel()
    assert (z**2).sum() == pytest.approx(values @ np.linalg.solve(C, values), rel=1e-9)
    assert ln_S.sum() == pytest.approx(np.linalg.slogdet(C)[1], rel=1e-9)
    assert (z[~there] == 0).all()


def test_a_wander_that_both_see_is_found_as_one() -> None:
    """Three axes that walk, seen in two directions that turn: what each output has of its own is little beside it."""
    rng = np.random.default_rng(9)
    n = 6000
    wander = np.stack([process(rng, n, 200.0, 4.0) for _ in range(3)], axis=1)
    angle = 0.05 * np.arange(n)
    output_axes = np.stack([np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])] * 2, axis=1)
    output_axes[:, 1] = 0.5 * np.roll(output_axes[:, 1], 1, axis=1)
    y = np.einsum("nqi,ni->nq", output_axes, wander) + rng.normal(size=(n, 2))
    noise_model = NoiseModel.of(Bands.of(y, 1.0, 1, STANDARD.bands), STANDARD, output_axes)
    assert noise_model.white == pytest.approx([1.0, 1.0], rel=0.15)
    assert noise_model.turning.sum() == pytest.approx(4.0**2, rel=0.5)
    assert noise_model.slow[0].sum() < 0.1 * noise_model.turning.sum()


def test_the_expected_spectrum_of_a_turning_wander_is_that_of_many() -> None:
    rng = np.random.default_rng(6)
    n, tau_s = 512, np.array([30.0])
    output_axes = np.column_stack([np.cos(0.3 * np.arange(n)), np.sin(0.3 * np.arange(n)), np.zeros(n)])
    expected = seen_density(output_axes[:, None], tau_s, 1.0, STANDARD)[0]
    kept, power = np.exp(-1 / 30.0), []
    for _ in range(400):
        steps = rng.normal(size=(n, 3)) * np.r_[1.0, np.full(n - 1, np.sqrt(1 - kept**2))][:, None]
        wander = lfilter([1.0], [1.0, -kept], steps, axis=0)
        power.append(Bands.of((wander * output_axes).sum(axis=1)[:, None], 1.0, 1, STANDARD.bands).power / 2)
    assert np.allclose(np.mean(power, axis=0)[3:] / expected[3:], 1.0, atol=0.25)
