"""Slow random noise in a residual: flicker noise, a random walk or a Gauss-Markov process, by the spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import chi2

from diagnosis.evidence.along_field import is_attitude_error
from diagnosis.evidence.localise import TIME, localise
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.residual_tests import has_heavy_tails
from diagnosis.library.parameter_search import between_neighbours
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.amplitude import rms
from validation.signals.bands import Bands, hann

Density = Callable[[Array], Array]


@dataclass(frozen=True)
class SlowNoise:
    """Slow noise: the effect at its fitted size, equally likely alternatives, and evidence in nats.

    identified: the noise dominates at enough frequencies to be distinguished from any slow disturbance. mean_std:
    standard deviation of its mean over the run, in units of the noise of a sample.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    gain: float
    identified: bool
    mean_std: float


def find_slow_noise(problem: LinearProblem, residual: Array) -> SlowNoise | None:
    """Slow noise of the offset in a residual (n, q) in units of the noise; None without evidence, or of another form.

    None where a channel explains more of the residual than time does, where the residual has no part along the field,
    as attitude errors have none, where it is likelier slow along the Earth's axes, and where the innovations are not
    random, or have heavy tails unless `wrong_values` leave them.
    """
    policy, interval_s, base = problem.policy, problem.state.interval_s, problem.base
    if (
        not follows_time_only(problem, residual)
        or is_attitude_error(problem, residual)
        or is_earth_frame_noise(problem, residual)
    ):
        return None
    if problem.level is not None:  # the dip has the slow errors of roll and pitch too
        residual, base = residual[:, :1], base[:, 0]
    residual = _refitted(residual, base, SlowSpectrum.of(residual, interval_s, policy))
    spectrum = SlowSpectrum.of(residual, interval_s, policy)
    found = fit_axes(residual, problem.usable, spectrum, policy)
    heavy = not problem.wrong_values and has_heavy_tails(found.innovations, policy)
    steps = _step_means(found.innovations, problem.state.time_s, policy)
    if heavy or found.gain <= policy.apart or not (spectrum.agrees(policy) and is_random(steps, policy)):
        return None
    std_nT = np.sqrt(np.resize(found.sizes, 3)) * np.resize(problem.sigma_nT[: residual.shape[1]], 3)
    identified = spectrum.lines_above_white(policy) >= policy.least_noise_lines
    mean_std = spectrum.mean_std(float(np.mean(found.sizes)))
    return SlowNoise(spectrum.as_effect(std_nT), spectrum.others, found.gain, identified, mean_std)


def follows_time_only(problem: LinearProblem, residual: Array) -> bool:
    """Whether no channel explains more of a residual (n, q) than time does."""
    shares = {share.channel: share.share for share in localise(problem, residual)}
    return max(shares.values(), default=0.0) <= shares.get(TIME, 0.0) + problem.policy.little


def is_earth_frame_noise(problem: LinearProblem, residual: Array) -> bool:
    """Whether slow noise is likelier in a residual (n, 3) along the Earth's axes than along the sensor's.

    Sensor noise turns with the sensor; a changing field is fixed to the Earth.
    """
    if not problem.along_attitude:
        return False
    policy, interval_s = problem.policy, problem.state.interval_s
    body = problem.ahead_of_iron(residual * problem.sigma_nT) / rms(problem.sigma_nT)
    earth, own = (
        fit_axes(axes, problem.usable, SlowSpectrum.of(axes, interval_s, policy), policy).score
        for axes in (np.einsum("nij,nj->ni", problem.state.R_wb, body), body)
    )
    return earth > own + policy.apart


@dataclass(frozen=True)
class SlowSpectrum:
    """The best slow noise ``S(f) = level + size shape(f)`` of the library, and the names of equally good effects.

    By Whittle likelihood; densities are one-sided, in units of the noise squared per Hz: ``shape(f) = 1 / f`` for
    flicker noise, ``1 / (2 pi^2 f^2)`` for a random walk. listed : the effect's listed parameters by name.
    """

    bands: Bands
    effect: type[Effect]
    listed: dict[str, float]
    shape: Density
    likelihood: float
    level: float
    size: float
    others: tuple[str, ...] = ()

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> SlowSpectrum:
        """Fit every effect with a spectrum to a residual (n, q) in units of the noise, and select the best.

        Of equally good effects the one without a listed parameter, which has a number less.
        """
        bands = Bands.of(residual, interval_s, policy.first_line, policy.bands)
        fits = [cls._best(effect, bands, interval_s) for effect in EFFECTS if effect.traits.spectrum is not None]
        most = max(fit.likelihood for fit in fits)
        near = [fit for fit in fits if most - fit.likelihood < policy.apart]
        best = min(near, key=lambda fit: (len(fit.listed), -fit.likelihood))
        return replace(best, others=tuple(fit.effect.name for fit in near if fit is not best))

    @classmethod
    def _best(cls, effect: type[Effect], bands: Bands, interval_s: float) -> SlowSpectrum:
        """The effect at its listed parameter of largest likelihood, refined between the neighbours in the list."""
        spectrum = effect.traits.spectrum
        assert spectrum is not None

        def fit(listed: dict[str, float]) -> SlowSpectrum:
            shape = partial(spectrum, interval_s=interval_s, **listed)
            return cls(bands, effect, listed, shape, *bands.fit(shape(bands.f)))

        if not effect.search:
            return fit({})
        ((name, values),) = effect.search.items()
        first = max(values, key=lambda value: fit({name: value}).likelihood)
        return fit({name: between_neighbours(values, first, lambda x: -fit({name: x}).likelihood, within=0.02)})

    def density(self, f: Array) -> Array:
        """S(f) at frequencies f (m,)."""
        return np.asarray(self.level + self.size * self.shape(f))

    def as_effect(self, level: Array) -> Effect:
        """The effect with a level (3,) of the axes, in nT."""
        values: dict[str, Any] = {**self.listed, str(self.effect.with_role("level")): tuple(level.tolist())}
        return self.effect(**values)

    def mean_std(self, size: float) -> float:
        """Standard deviation ``(S(1 / 2T) / 2T)^1/2`` of the mean over the run T, S one-sided and of a given size."""
        run_s = self.bands.samples * self.bands.interval_s
        return float(np.sqrt(size * self.shape(np.array([0.5 / run_s]))[0] / (2 * run_s)))

    def agrees(self, policy: Policy) -> bool:
        """Whether no band deviates significantly from S."""
        ratio = self.bands.power / self.density(self.bands.f)
        return self.bands.chance(np.abs(ratio - 1) + 1) > policy.test_alarm

    def lines_above_white(self, policy: Policy) -> float:
        """Number of frequencies at which the slow noise exceeds the white noise."""
        return float(self.bands.shape[self.density(self.bands.f) > policy.clearly_larger * self.level].sum())


def _refitted(residual: Array, base: Array, spectrum: SlowSpectrum) -> Array:
    """A residual (n, q) with the base (n, p) fitted again, frequencies weighted by the inverse noise spectrum."""
    n, interval_s = len(residual), spectrum.bands.interval_s
    f = np.maximum(np.fft.rfftfreq(n, interval_s), 1 / (n * interval_s))
    weight = np.sqrt(spectrum.density(f))[:, None]
    B, r = (np.fft.rfft(hann(n) * values, axis=0) / weight for values in (base, residual))
    change = np.linalg.lstsq((B.conj().T @ B).real, (B.conj().T @ r).real, rcond=1e-12)[0]
    return np.asarray(residual - base @ change)


class AxesFit(NamedTuple):
    """Log-likelihood, gain in nats over white noise, size (q,) of each axis, and innovations (n, q) where known."""

    score: float
    gain: float
    sizes: Array
    innovations: Array


def fit_axes(residual: Array, usable: Array, spectrum: SlowSpectrum, policy: Policy) -> AxesFit:
    """Fit the size of a slow noise in each axis of a residual (n, q), and whiten the residual by the noise.

    Samples that are not usable (n,) are unknown, not 0. From the size by Whittle likelihood, with a parabola through
    the log-likelihoods of half and twice the size. The white noise is one level for all axes, since turns of the axes
    mix their noise.
    """
    length = -(-len(residual) // policy.most_rows)
    rows, known = map(Cut(length, len(residual) // length).means, (residual, usable))
    bands = Bands.of(rows, length * spectrum.bands.interval_s, 1, policy.bands)
    shape = spectrum.shape(bands.f)
    sizes = np.array([replace(bands, density=own[None]).fit(shape)[2] for own in bands.density])

    def whitened(sizes: Array) -> tuple[Array, Array]:
        return _whitened(rows, known, replace(bands, density=spectrum.level + np.outer(sizes, shape)), policy)

    less, same, more = (whitened(factor * sizes)[1] for factor in (0.5, 1.0, 2.0))
    sizes *= 2 ** np.clip((more - less) / 2 / np.maximum(2 * same - less - more, 1e-9), -1, 1)
    (innovations, score), white = whitened(sizes), whitened(0 * sizes)[1]
    return AxesFit(float(score.sum()), float((score - white).sum()), sizes, innovations[known > 0])


def _whitened(rows: Array, known: Array, bands: Bands, policy: Policy) -> tuple[Array, Array]:
    """Innovations (m, q) of rows with a known share (m,), by a spectrum in bands, and the log-likelihood (q,)."""
    time_s: Array = bands.interval_s * np.arange(len(rows), dtype=np.float64)
    z, ln_S = NoiseModel.of(bands, policy).whitened(time_s, np.ceil(known), rows[:, :, None])
    return z[:, :, 0], -(z[:, :, 0] ** 2 + ln_S).sum(axis=0) / 2


def _step_means(rows: Array, time_s: Array, policy: Policy) -> Array:
    """Means (m, q) of rows (n, q) of the samples at times (N,) over `step_s`, `least_steps` to `most_steps` of them."""
    n, row_s = len(rows), float(np.median(np.diff(time_s))) * (-(-len(time_s) // policy.most_rows))
    length = max(1, min(round(policy.step_s / row_s), n // policy.least_steps), n // policy.most_steps)
    return Cut(length, n // length).means(rows)


def is_random(innovations: Array, policy: Policy) -> bool:
    """Whether innovations (n, q) have no isolated jump, no steady trend and no significant slow oscillation."""
    z = innovations / innovations.std(axis=0)
    n, q = z.shape
    beyond = np.concatenate([np.zeros((1, q)), np.cumsum(z, axis=0)])
    courses = [np.abs(beyond[w:] - beyond[:-w]).max() / np.sqrt(w) for w in 2 ** np.arange(int(np.log2(n)) + 1)]
    swings = np.array([(z[lag:] * z[:-lag]).sum() ** 2 / (n - lag) / q for lag in range(1, policy.swing_lags + 1)])
    return bool(max(courses) < policy.far_sigma and chi2.sf(swings.sum(), policy.swing_lags) > policy.test_alarm)
