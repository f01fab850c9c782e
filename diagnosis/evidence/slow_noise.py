"""Slow random noise in a residual: flicker noise or random walk, distinguished by the slope of the spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from diagnosis.evidence.along_field import is_attitude_error
from diagnosis.evidence.localise import TIME, localise
from diagnosis.evidence.slow_spectrum import SlowSpectrum
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.base import Effect
from validation.signals.amplitude import rms
from validation.signals.bands import hann

LOG_SIZES = (-14.0, 14.0)
"""Range of the logarithm of the slow noise's size over the power of the white noise, in the search."""
Density = Callable[[Array], Array]


@dataclass(frozen=True)
class SlowNoise:
    """Slow noise: the effect at its fitted size, equally likely alternatives, and evidence in nats.

    score: log-likelihood of the steps between block means; fits: spectrum and steps agree with the effect; identified:
    the noise dominates at enough frequencies to be distinguished from any slow disturbance.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    gain: float
    score: float
    fits: bool
    identified: bool


def find_slow_noise(problem: LinearProblem, residual: Array) -> SlowNoise | None:
    """Slow noise in a residual (n, q), unless a channel explains more of the residual than time does."""
    return slow_noise(problem, residual) if follows_time_only(problem, residual) else None


def follows_time_only(problem: LinearProblem, residual: Array) -> bool:
    """Whether no channel explains more of a residual (n, q) than time does."""
    shares = {share.channel: share.share for share in localise(problem, residual)}
    return max(shares.values(), default=0.0) <= shares.get(TIME, 0.0) + problem.policy.little


def slow_noise(problem: LinearProblem, residual: Array) -> SlowNoise | None:
    """Flicker noise or random walk of the offset in a residual (n, q) in units of the noise; None without evidence.

    Whittle likelihood of the band-averaged periodogram: ``S(f) = w + d^2 / f`` or ``w + q^2 / (2 pi^2 f^2)``,
    one-sided, in units of the noise squared per Hz. None where the residual has no part along the field, as attitude
    errors have none, or is likelier slow along the Earth's axes.
    """
    policy, interval_s = problem.policy, problem.state.interval_s
    if is_attitude_error(problem, residual) or is_earth_frame_noise(problem, residual):
        return None
    base = problem.base
    if problem.level is not None:  # the dip has the slow errors of roll and pitch too
        residual, base = residual[:, :1], base[:, 0]
    first = SlowSpectrum.of(residual, interval_s, policy)
    residual = _refitted(residual, base, interval_s, first.density)
    spectrum = SlowSpectrum.of(residual, interval_s, policy)
    steps = Steps.of(residual, interval_s, policy)
    score, sizes, innovations = steps.fit(spectrum.level, spectrum.shape)
    gain = score - steps.fit(spectrum.level, None)[0]
    if gain <= policy.apart:
        return None
    level = spectrum.effect.with_role("level")
    assert level is not None
    std = np.sqrt(np.resize(sizes, 3)) * np.resize(problem.sigma_nT[: len(sizes)], 3)
    values: dict[str, Any] = {**spectrum.listed, level: tuple(std.tolist())}
    return SlowNoise(
        spectrum.effect(**values),
        spectrum.others,
        gain,
        score,
        fits=spectrum.agrees(policy) and is_random(innovations, policy),
        identified=spectrum.lines_above_white(policy) >= policy.least_noise_lines,
    )


def is_earth_frame_noise(problem: LinearProblem, residual: Array) -> bool:
    """Whether slow noise is likelier in a residual (n, 3) along the Earth's axes than along the sensor's.

    Sensor noise turns with the sensor; a changing field is fixed to the Earth.
    """
    if problem.mode != "vector" or not problem.compares_across:
        return False
    body = (residual * problem.sigma_nT) @ np.linalg.inv(problem.turn).T / rms(problem.sigma_nT)
    earth = np.einsum("nij,nj->ni", problem.state.R_wb, body)
    return _score(problem, earth) > _score(problem, body) + problem.policy.apart


def _score(problem: LinearProblem, residual: Array) -> float:
    """Log-likelihood of the steps of a residual (n, q) under the slow noise that fits the spectrum best."""
    policy, interval_s = problem.policy, problem.state.interval_s
    spectrum = SlowSpectrum.of(residual, interval_s, policy)
    return Steps.of(residual, interval_s, policy).fit(spectrum.level, spectrum.shape)[0]


def _refitted(residual: Array, base: Array, interval_s: float, density: Density) -> Array:
    """A residual (n, q) with the base (n, p) fitted again, frequencies weighted by the inverse noise spectrum."""
    n = len(residual)
    window = hann(n)
    f = np.maximum(np.fft.rfftfreq(n, interval_s), 1 / (n * interval_s))
    B, r = (np.fft.rfft(window * values, axis=0) / np.sqrt(density(f))[:, None] for values in (base, residual))
    change = np.linalg.lstsq((B.conj().T @ B).real, (B.conj().T @ r).real, rcond=1e-12)[0]
    return np.asarray(residual - base @ change)


@dataclass(frozen=True)
class Steps:
    """Steps (n, q) between means over blocks of `block_s`, of a residual in units of the noise."""

    values: Array
    block_s: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> Steps:
        """Steps of a residual (n, q) between blocks of `step_s`, adapted to give `least_steps` to `most_steps`."""
        n = len(residual)
        length = max(1, min(round(policy.step_s / interval_s), n // policy.least_steps), n // policy.most_steps)
        return cls(np.diff(Cut(length, n // length).means(residual), axis=0), length * interval_s)

    def correlation(self, density: Density) -> Array:
        """``r_k = int S(f) sinc^2(f T) 4 sin^2(pi f T) cos(2 pi f k T) df`` (n,) of the steps under a spectrum S."""
        n, T = len(self.values), self.block_s
        f = np.asarray((np.arange(32 * n) + 0.5) / (8 * n * T), dtype=np.float64)
        power = density(f) * np.sinc(f * T) ** 2 * 4 * np.sin(np.pi * f * T) ** 2 / (8 * n * T)
        return np.array([power @ np.cos(2 * np.pi * f * k * T) for k in range(n)])

    def fit(self, level: float, shape: Density | None) -> tuple[float, Array, Array]:
        """Log-likelihood, size s (q,) of each axis and innovations (n, q) under ``S = level + s shape``."""
        white = self.correlation(lambda f: np.full(len(f), level))
        slow = np.zeros(len(white)) if shape is None else self.correlation(shape)
        parts = [_axis(column, white, slow) for column in self.values.T]
        return sum(p[0] for p in parts), np.array([p[1] for p in parts]), np.stack([p[2] for p in parts], axis=1)


def _axis(steps: Array, white: Array, slow: Array) -> tuple[float, float, Array]:
    """Log-likelihood, size and innovations (n,) of one axis."""
    if not slow.any():
        score, z = _likelihood(steps, white)
        return score, 0.0, z
    scale = white[0] / slow[0]
    best = minimize_scalar(
        lambda x: -_likelihood(steps, white + np.exp(x) * scale * slow)[0], bounds=LOG_SIZES, method="bounded",
        options={"xatol": 0.05, "maxiter": 25},
    )  # fmt: skip
    size = float(np.exp(best.x) * scale)
    score, z = _likelihood(steps, white + size * slow)
    return score, size, z


def _likelihood(steps: Array, row: Array) -> tuple[float, Array]:
    factor = np.linalg.cholesky(toeplitz(row))
    z: Array = np.asarray(np.linalg.solve(factor, steps), dtype=np.float64)
    return float(-np.log(np.diag(factor)).sum() - (z**2).sum() / 2), z


def is_random(innovations: Array, policy: Policy) -> bool:
    """Whether innovations (n, q) have no isolated jump, no steady trend and no significant slow oscillation."""
    z = innovations / innovations.std(axis=0)
    n, q = z.shape
    beyond = np.concatenate([np.zeros((1, q)), np.cumsum(z, axis=0)])
    courses = [np.abs(beyond[w:] - beyond[:-w]).max() / np.sqrt(w) for w in 2 ** np.arange(int(np.log2(n)) + 1)]
    swings = np.array([(z[lag:] * z[:-lag]).sum() ** 2 / (n - lag) / q for lag in range(1, policy.swing_lags + 1)])
    return bool(max(courses) < policy.far_sigma and chi2.sf(swings.sum(), policy.swing_lags) > policy.test_alarm)
