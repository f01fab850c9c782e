"""Slow random disturbances in what is left: flicker and random walk, told apart by the spectrum's slope."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import minimize
from scipy.stats import chi2, gamma

from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.compare import THRESHOLD
from validation.diagnosis.problem import Problem

BINS = 40
ALONG = 0.12
"""Share of slow power along the field below which it is a turn of the attitude: that of three equal axes is 1/3."""
POOR = 1e-3
STEP_S, MOST_STEPS, ODD, SWINGS = 5.0, 400, 5.0, 8
"""Length of a block and most of them; most standard deviations of innovations added up; lags that are tested."""
TOLD = 30
"""Frequencies at which a disturbance must stand out for its nature to be told; below that it is just slow."""
Density = Callable[[Array], Array]


@dataclass(frozen=True)
class Noise:
    """Slow noise: the effect at its fitted size, those as good, evidence in nats.

    score: log-likelihood of the residual's spectrum; fits: the spectrum and the steps agree; told: it stands out at so
    many frequencies that its nature is told from that of any slow disturbance.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    gain: float
    score: float
    fits: bool
    told: bool

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name


def slow_noise(problem: Problem, residual: Array) -> Noise | None:
    """Flicker noise or an offset's random walk in a residual (n, q) in units of the noise; None if neither is there.

    Whittle likelihood of the periodogram averaged in bands: ``S(f) = w + d^2 / f`` or ``w + q^2 / (2 pi^2 f^2)``,
    one-sided, in units of the noise squared over Hz. An error of the attitude has no part along the field, a noise of
    the sensor has: where it is missing, None.
    """
    if problem.mode == "vector" and along_field(problem, residual) < ALONG:
        return None
    interval_s = problem.state.interval_s
    f, power, dof = _bands(residual, interval_s)
    shapes: dict[str, Callable[[Array], Array]] = {
        "flicker_noise": lambda x: 1 / x,
        "offset_random_walk": lambda x: 1 / (2 * np.pi**2 * x**2),
    }
    fits = {name: _best(f, power, dof, 2 * interval_s, shape(f)) for name, shape in shapes.items()}
    best = max(fits, key=lambda name: fits[name][0])
    gain = fits[best][0] - white_score(residual, interval_s)
    if gain <= THRESHOLD:
        return None
    others = tuple(name for name in fits if name != best and fits[best][0] - fits[name][0] < THRESHOLD)
    score, level, size = fits[best]
    expected = level + size * shapes[best](f)
    odd = gamma.sf(np.abs(power / expected - 1) + 1, dof, scale=1 / dof)
    agrees = odd.min() > POOR / len(f) and wanders(residual, interval_s, lambda x: level + size * shapes[best](x))
    std = tuple(float(np.sqrt(size) * s) for s in np.resize(problem.sigma_nT, 3))
    parameter = BY_NAME[best].parameters()[0].name
    out = float(dof[expected > 2 * level].sum())
    return Noise(BY_NAME[best](**{parameter: std}), others, gain, score, bool(agrees), out >= TOLD)


def white_score(residual: Array, interval_s: float) -> float:
    """Log-likelihood of a residual's spectrum (n, q) if it is white, of whatever size; beside `Noise.score`."""
    f, power, dof = _bands(residual, interval_s)
    return _best(f, power, dof, 2 * interval_s, np.zeros(len(f)))[0]


def wanders(residual: Array, interval_s: float, density: Density) -> bool:
    """Whether the steps between block means look drawn at random, with the spectrum S(f) as `density` gives it.

    ``r_k = int S(f) sinc^2(f T) 4 sin^2(pi f T) cos(2 pi f k T) df`` is the covariance of the steps; its Cholesky
    factor turns them into innovations, which no lone jump, steady course or slow swing may stand out of.
    """
    length = max(1, min(round(STEP_S / interval_s), len(residual) // 40), len(residual) // MOST_STEPS)
    m = len(residual) // length
    steps = np.diff(residual[: m * length].reshape(m, length, -1).mean(axis=1), axis=0)
    z = np.linalg.solve(_factor(density, length * interval_s, len(steps)), steps)
    z = z / z.std(axis=0)
    n, q = z.shape
    beyond = np.concatenate([np.zeros((1, q)), np.cumsum(z, axis=0)])
    courses = [np.abs(beyond[w:] - beyond[:-w]).max() / np.sqrt(w) for w in 2 ** np.arange(int(np.log2(n)) + 1)]
    swings = np.array([(z[lag:] * z[:-lag]).sum() ** 2 / (n - lag) / q for lag in range(1, SWINGS + 1)])
    return bool(max(courses) < ODD and chi2.sf(swings.sum(), SWINGS) > POOR)


def _factor(density: Density, block_s: float, n: int) -> Array:
    """Cholesky factor (n, n) of the covariance of n steps between means over blocks."""
    f = np.asarray((np.arange(32 * n) + 0.5) / (8 * n * block_s), dtype=np.float64)
    power = density(f) * np.sinc(f * block_s) ** 2 * 4 * np.sin(np.pi * f * block_s) ** 2
    row = np.array([power @ np.cos(2 * np.pi * f * k * block_s) for k in range(n)])
    return np.asarray(np.linalg.cholesky(toeplitz(row)))


def along_field(problem: Problem, residual: Array) -> float:
    """Share of the slow residual's power that lies along the field."""
    length = max(1, round(5.0 / problem.state.interval_s))
    m = len(residual) // length
    turned = problem.state.field_nT @ problem.turn.T
    direction = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    nT = (residual * problem.sigma_nT)[: m * length].reshape(m, length, -1).mean(axis=1)
    u = direction[: m * length].reshape(m, length, -1).mean(axis=1)
    return float(((nT * u).sum(axis=1) ** 2).sum() / max((nT**2).sum(), 1e-300))


def _bands(residual: Array, interval_s: float) -> tuple[Array, Array, Array]:
    """Mean frequency, power density and gamma shape of bands evenly spaced in log f."""
    n, q = residual.shape
    power = (np.abs(np.fft.rfft(residual, axis=0)) ** 2).sum(axis=1) * 2 * interval_s / n / q
    f = np.fft.rfftfreq(n, interval_s)
    edges = np.unique(np.geomspace(1, len(f) - 1, BINS).astype(int))
    band = [slice(a, b) for a, b in itertools.pairwise(edges)]
    return (
        np.array([f[b].mean() for b in band]),
        np.array([power[b].mean() for b in band]),
        np.array([q * (b.stop - b.start) for b in band], dtype=float),
    )


def _best(f: Array, power: Array, dof: Array, white: float, shape: Array) -> tuple[float, float, float]:
    """Greatest log-likelihood, and the white level and the size of the shape there."""

    def cost(x: Array) -> float:
        S = np.exp(x[0]) + np.exp(x[1]) * shape
        return float((dof * (np.log(S) + power / S)).sum())

    start = np.log([white, max(power[0] / max(shape[0], 1e-300), 1e-12)]) if shape.any() else np.log([white, 1.0])
    found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 400, "xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun), float(np.exp(found.x[0])), float(np.exp(found.x[1]))
