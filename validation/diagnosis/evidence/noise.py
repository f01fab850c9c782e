"""Slow random disturbances in what is left: flicker and random walk, told apart by the spectrum's slope."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.stats import gamma

from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.evidence.compare import THRESHOLD
from validation.diagnosis.evidence.direct import vec3
from validation.diagnosis.evidence.problem import Problem
from validation.signals.steps import Density, Steps, drawn_at_random

BINS = 40
ALONG = 0.12
"""Share of slow power along the field below which it is a turn of the attitude: that of three equal axes is 1/3."""
POOR = 1e-3
SHAPES: dict[str, Density] = {
    "flicker_noise": lambda f: 1 / f,
    "offset_random_walk": lambda f: 1 / (2 * np.pi**2 * f**2),
}
NEIGHBOURS = 35 / 18
"""By how much a Hann window correlates neighbouring lines: lines over independent ones."""
TOLD = 30
"""Frequencies at which a disturbance must stand out for its nature to be told; below that it is just slow."""


@dataclass(frozen=True)
class Noise:
    """Slow noise: the effect at its fitted size, those as good, evidence in nats.

    score: log-likelihood of the steps between its block means; fits: the spectrum and the steps agree; told: it stands
    out at so many frequencies that its nature is told from that of any slow disturbance.
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
    residual = _refitted(residual, problem.base, interval_s, _Spectrum.of(residual, interval_s).density)
    spectrum = _Spectrum.of(residual, interval_s)
    steps = Steps.of(residual, interval_s)
    score, sizes, innovations = steps.fit(spectrum.level, SHAPES[spectrum.best])
    gain = score - steps.fit(spectrum.level, None)[0]
    if gain <= THRESHOLD:
        return None
    std = vec3(np.sqrt(np.resize(sizes, 3)) * np.resize(problem.sigma_nT, 3))
    effect = BY_NAME[spectrum.best]
    return Noise(
        effect(**{effect.parameters()[0].name: std}), spectrum.others, gain, score,
        fits=spectrum.agrees() and drawn_at_random(innovations), told=spectrum.outstanding() >= TOLD,
    )  # fmt: skip


@dataclass(frozen=True)
class _Spectrum:
    """Power of a residual in bands, and the best slow noise in it: ``S = level + size SHAPES[best]``."""

    f: Array
    power: Array
    dof: Array
    best: str
    others: tuple[str, ...]
    level: float
    size: float

    @classmethod
    def of(cls, residual: Array, interval_s: float) -> _Spectrum:
        f, power, dof = spectrum_bands(residual, interval_s)
        fits = {name: _best(f, power, dof, 2 * interval_s, shape(f)) for name, shape in SHAPES.items()}
        best = max(fits, key=lambda name: fits[name][0])
        others = tuple(name for name in fits if name != best and fits[best][0] - fits[name][0] < THRESHOLD)
        return cls(f, power, dof, best, others, *fits[best][1:])

    def density(self, f: Array) -> Array:
        """S(f)."""
        return np.asarray(self.level + self.size * SHAPES[self.best](f))

    def agrees(self) -> bool:
        """Whether no band is far from S."""
        ratio = self.power / self.density(self.f)
        odd = gamma.sf(np.abs(ratio - 1) + 1, self.dof, scale=1 / self.dof)
        return bool(odd.min() > POOR / len(self.f))

    def outstanding(self) -> float:
        """At how many frequencies the slow noise is larger than the white one."""
        return float(self.dof[self.density(self.f) > 2 * self.level].sum())


def white_score(problem: Problem, residual: Array) -> float:
    """Log-likelihood of a residual's steps (n, q) if it is white, of whatever size; beside `Noise.score`."""
    interval_s = problem.state.interval_s
    f, power, dof = spectrum_bands(residual, interval_s)
    level = _best(f, power, dof, 2 * interval_s, np.zeros(len(f)))[1]
    return Steps.of(residual, interval_s).fit(level, None)[0]


def _refitted(residual: Array, base: Array, interval_s: float, density: Density) -> Array:
    """A residual (n, q) with the base (n, p) fitted anew, each frequency weighing what the noise's spectrum says."""
    n = len(residual)
    window = np.sin(np.pi * (np.arange(n) + 0.5) / n)[:, None] ** 2
    f = np.maximum(np.fft.rfftfreq(n, interval_s), 1 / (n * interval_s))
    B, r = (np.fft.rfft(window * values, axis=0) / np.sqrt(density(f))[:, None] for values in (base, residual))
    change = np.linalg.lstsq((B.conj().T @ B).real, (B.conj().T @ r).real, rcond=1e-12)[0]
    return np.asarray(residual - base @ change)


def along_field(problem: Problem, residual: Array) -> float:
    """Share of the slow residual's power that lies along the field."""
    length = max(1, round(5.0 / problem.state.interval_s))
    m = len(residual) // length
    turned = problem.state.field_nT @ problem.turn.T
    direction = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    nT = (residual * problem.sigma_nT)[: m * length].reshape(m, length, -1).mean(axis=1)
    u = direction[: m * length].reshape(m, length, -1).mean(axis=1)
    return float(((nT * u).sum(axis=1) ** 2).sum() / max((nT**2).sum(), 1e-300))


def spectrum_bands(residual: Array, interval_s: float) -> tuple[Array, Array, Array]:
    """Mean frequency, power density and gamma shape of bands evenly spaced in log f, under a Hann window."""
    n, q = residual.shape
    window = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
    varying = residual - residual.mean(axis=0)
    power = (np.abs(np.fft.rfft(varying * window[:, None], axis=0)) ** 2).sum(axis=1)
    power *= 2 * interval_s / (window**2).sum() / q
    f = np.fft.rfftfreq(n, interval_s)
    edges = np.unique(np.geomspace(2, len(f) - 1, BINS).astype(int))
    band = [slice(a, b) for a, b in itertools.pairwise(edges)]
    return (
        np.array([f[b].mean() for b in band]),
        np.array([power[b].mean() for b in band]),
        np.array([max(q, q * (b.stop - b.start) / NEIGHBOURS) for b in band], dtype=float),
    )


def _best(f: Array, power: Array, dof: Array, white: float, shape: Array) -> tuple[float, float, float]:
    """Greatest log-likelihood, and the white level and the size of the shape there."""

    def cost(x: Array) -> float:
        S = np.exp(x[0]) + np.exp(x[1]) * shape
        return float((dof * (np.log(S) + power / S)).sum())

    start = np.log([white, max(power[0] / max(shape[0], 1e-300), 1e-12)]) if shape.any() else np.log([white, 1.0])
    found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 400, "xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun), float(np.exp(found.x[0])), float(np.exp(found.x[1]))
