"""Slow random noise in a residual: flicker noise, a random walk or a Gauss-Markov process, by the spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cholesky, solve_triangular, toeplitz
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from diagnosis.evidence.along_field import is_attitude_error
from diagnosis.evidence.localise import TIME, localise
from diagnosis.library.parameter_search import between_neighbours
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.amplitude import rms
from validation.signals.bands import Bands, hann

LOG_SIZES = (-14.0, 14.0)
"""Range of the logarithm of the slow noise's size over the power of the white noise, in the search."""
Density = Callable[[Array], Array]
Fit = tuple[float, float, float]
"""Likelihood, white level and size of the slow noise."""


@dataclass(frozen=True)
class SlowNoise:
    """Slow noise: the effect at its fitted size, equally likely alternatives, and evidence in nats.

    fits: spectrum and innovations agree with the effect; identified: the noise dominates at enough frequencies to be
    distinguished from any slow disturbance.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    gain: float
    fits: bool
    identified: bool


def find_slow_noise(problem: LinearProblem, residual: Array) -> SlowNoise | None:
    """Slow noise of the offset in a residual (n, q) in units of the noise; None without evidence.

    None where a channel explains more of the residual than time does, where the residual has no part along the field,
    as attitude errors have none, and where it is likelier slow along the Earth's axes.
    """
    policy, interval_s = problem.policy, problem.state.interval_s
    if (
        not follows_time_only(problem, residual)
        or is_attitude_error(problem, residual)
        or is_earth_frame_noise(problem, residual)
    ):
        return None
    base = problem.base
    if problem.level is not None:  # the dip has the slow errors of roll and pitch too
        residual, base = residual[:, :1], base[:, 0]
    residual = _refitted(residual, base, SlowSpectrum.of(residual, interval_s, policy))
    spectrum = SlowSpectrum.of(residual, interval_s, policy)
    steps = Steps.of(residual, interval_s, policy)
    score, sizes, innovations = steps.fit(spectrum.level, spectrum.shape)
    gain = score - steps.fit(spectrum.level, None)[0]
    if gain <= policy.apart:
        return None
    level = spectrum.effect.with_role("level")
    assert level is not None
    std = np.sqrt(np.resize(sizes, 3)) * np.resize(problem.sigma_nT[: residual.shape[1]], 3)
    values: dict[str, Any] = {**spectrum.listed, level: tuple(std.tolist())}
    return SlowNoise(
        spectrum.effect(**values),
        spectrum.others,
        gain,
        fits=spectrum.agrees(policy) and is_random(innovations, policy),
        identified=spectrum.lines_above_white(policy) >= policy.least_noise_lines,
    )


def follows_time_only(problem: LinearProblem, residual: Array) -> bool:
    """Whether no channel explains more of a residual (n, q) than time does."""
    shares = {share.channel: share.share for share in localise(problem, residual)}
    return max(shares.values(), default=0.0) <= shares.get(TIME, 0.0) + problem.policy.little


def is_earth_frame_noise(problem: LinearProblem, residual: Array) -> bool:
    """Whether slow noise is likelier in a residual (n, 3) along the Earth's axes than along the sensor's.

    Sensor noise turns with the sensor; a changing field is fixed to the Earth.
    """
    if problem.mode != "vector" or not problem.compares_across:
        return False
    body = (residual * problem.sigma_nT) @ np.linalg.inv(problem.turn).T / rms(problem.sigma_nT)
    earth = np.einsum("nij,nj->ni", problem.state.R_wb, body)
    policy, interval_s = problem.policy, problem.state.interval_s

    def score(axes: Array) -> float:
        spectrum = SlowSpectrum.of(axes, interval_s, policy)
        return Steps.of(axes, interval_s, policy).fit(spectrum.level, spectrum.shape)[0]

    return score(earth) > score(body) + policy.apart


@dataclass(frozen=True)
class SlowSpectrum:
    """The best slow noise ``S(f) = level + size shape(f)`` of the library, and the names of equally good effects.

    Whittle likelihood of the band-averaged periodogram, one-sided, in units of the noise squared per Hz: ``shape(f) =
    1 / f`` for flicker noise, ``1 / (2 pi^2 f^2)`` for a random walk. listed : the effect's listed parameters, such as
    a correlation time, by name.
    """

    bands: Bands
    effect: type[Effect]
    listed: dict[str, float]
    interval_s: float
    others: tuple[str, ...]
    level: float
    size: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> SlowSpectrum:
        """Fit every effect with a spectrum to a residual (n, q) in units of the noise, and select the best.

        Of equally good effects the one without a listed parameter, which has a number less.
        """
        bands = Bands.of(residual, interval_s, policy.first_line, policy.bands)
        fits = {effect: _best(effect, bands, interval_s) for effect in EFFECTS if effect.traits.spectrum is not None}
        most = max(score for _, (score, *_) in fits.values())
        near = [effect for effect in fits if most - fits[effect][1][0] < policy.apart]
        best = min(near, key=lambda effect: (len(effect.search), -fits[effect][1][0]))
        others = tuple(effect.name for effect in near if effect is not best)
        listed, (_, level, size) = fits[best]
        return cls(bands, best, listed, interval_s, others, level, size)

    def shape(self, f: Array) -> Array:
        """Density of the effect at unit level, at frequencies f (m,)."""
        return _shape(self.effect, f, self.interval_s, self.listed)

    def density(self, f: Array) -> Array:
        """S(f) at frequencies f (m,)."""
        return np.asarray(self.level + self.size * self.shape(f))

    def agrees(self, policy: Policy) -> bool:
        """Whether no band deviates significantly from S."""
        ratio = self.bands.power / self.density(self.bands.f)
        odds = self.bands.odds(np.abs(ratio - 1) + 1)
        return bool(odds.min() > policy.test_alarm / len(odds))

    def lines_above_white(self, policy: Policy) -> float:
        """Number of frequencies at which the slow noise exceeds the white noise."""
        return float(self.bands.shape[self.density(self.bands.f) > policy.clearly_larger * self.level].sum())


def _shape(effect: type[Effect], f: Array, interval_s: float, listed: dict[str, float]) -> Array:
    assert effect.traits.spectrum is not None
    return effect.traits.spectrum(f, interval_s, **listed)


def _best(effect: type[Effect], bands: Bands, interval_s: float) -> tuple[dict[str, float], Fit]:
    """The listed parameters of largest likelihood, refined between their neighbours, and the fit."""

    def fit(listed: dict[str, float]) -> Fit:
        return bands.fit(2 * interval_s, _shape(effect, bands.f, interval_s, listed))

    if not effect.search:
        return {}, fit({})
    ((name, values),) = effect.search.items()
    first = max(values, key=lambda value: fit({name: value})[0])
    first = between_neighbours(values, first, lambda x: -fit({name: x})[0], within=0.02)
    return {name: first}, fit({name: first})


def _refitted(residual: Array, base: Array, spectrum: SlowSpectrum) -> Array:
    """A residual (n, q) with the base (n, p) fitted again, frequencies weighted by the inverse noise spectrum."""
    n, interval_s = len(residual), spectrum.interval_s
    f = np.maximum(np.fft.rfftfreq(n, interval_s), 1 / (n * interval_s))
    weight = np.sqrt(spectrum.density(f))[:, None]
    B, r = (np.fft.rfft(hann(n) * values, axis=0) / weight for values in (base, residual))
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
        scale, sizes = white[0] / max(slow[0], 1e-300), np.zeros(self.values.shape[1])
        for axis, steps in enumerate(self.values.T if slow.any() else ()):
            best = minimize_scalar(
                lambda x, steps: -_likelihood(steps, white + np.exp(x) * scale * slow)[0], args=(steps,),
                bounds=LOG_SIZES, method="bounded", options={"xatol": 0.05, "maxiter": 25},
            )  # fmt: skip
            sizes[axis] = np.exp(best.x) * scale
        found = [_likelihood(steps, white + s * slow) for steps, s in zip(self.values.T, sizes, strict=True)]
        return sum(score for score, _ in found), sizes, np.stack([z for _, z in found], axis=1)


def _likelihood(steps: Array, row: Array) -> tuple[float, Array]:
    """Log-likelihood of steps (n,) whose correlation is a row (n,), but for a constant, and innovations (n,)."""
    factor = cholesky(toeplitz(row), lower=True)
    z = np.asarray(solve_triangular(factor, steps, lower=True), dtype=np.float64)
    return float(-np.log(np.diag(factor)).sum() - (z**2).sum() / 2), z


def is_random(innovations: Array, policy: Policy) -> bool:
    """Whether innovations (n, q) have no isolated jump, no steady trend and no significant slow oscillation."""
    z = innovations / innovations.std(axis=0)
    n, q = z.shape
    beyond = np.concatenate([np.zeros((1, q)), np.cumsum(z, axis=0)])
    courses = [np.abs(beyond[w:] - beyond[:-w]).max() / np.sqrt(w) for w in 2 ** np.arange(int(np.log2(n)) + 1)]
    swings = np.array([(z[lag:] * z[:-lag]).sum() ** 2 / (n - lag) / q for lag in range(1, policy.swing_lags + 1)])
    return bool(max(courses) < policy.far_sigma and chi2.sf(swings.sum(), policy.swing_lags) > policy.test_alarm)
