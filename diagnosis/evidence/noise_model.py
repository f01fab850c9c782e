"""Noise model of a residual: white noise plus Ornstein-Uhlenbeck processes, and the whitening Kalman filter."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from calib.numerics.innovations import innovations
from calib.numerics.kernels import fast_kernel
from diagnosis.policy import Policy
from scenarios.arrays import Array
from validation.signals.bands import Bands, even_bands, hann

ROUNDS = 3000
"""Updates of the variances: enough for the likelihood of a random walk to converge within a nat."""
LEAST_WHITE = 1e-3
"""Least share of white noise in the residual's variance: a filter without white noise interpolates."""
LEAST_SLOW = 1e-7
"""Variance over the white variance below which a process is left out."""
LEAST_POWER = 1e-12
"""Least power of a band and least variance of an output, since the base may fit a recording of a few fields exactly."""


@dataclass(frozen=True)
class NoiseModel:
    """``r = white + sum_j OU(tau_j)``: variances `white` (q,) and `slow` (q, J), time constants `tau_s` (J,).

    Where the outputs are projections of a vector on `output_axes` u (n, q, 3), the model also has ``u . (OU_x, OU_y,
    OU_z)(tau_j)``: a wander of the sensor axes with variances `turning` (J,), modulated by the motion and common to all
    outputs.
    """

    tau_s: Array
    white: Array
    slow: Array
    turning: Array = field(default_factory=lambda: np.zeros(0))
    output_axes: Array | None = None

    @classmethod
    def of(cls, bands: Bands, policy: Policy, output_axes: Array | None = None, *, walking: bool = False) -> NoiseModel:
        """Fit the variances to the spectrum of a residual by the banded Whittle likelihood.

        ``min sum_b a_b (ln S_b + P_b / S_b)`` over bands b of a_b lines under a Hann window, S the sum of the
        processes' spectra; each update multiplies a variance by ``sum a P s / S^2 / sum a s / S``. walking : white
        noise and a random walk of the axes alone.
        """
        interval_s, density = bands.interval_s, bands.density / (2 * bands.interval_s)
        longest_s = policy.longest_memory * bands.samples * interval_s
        tau_s = np.geomspace(policy.shortest_memory * interval_s, longest_s, policy.memories)[-1 if walking else 0 :]
        own = np.concatenate([np.ones((1, len(bands.f))), ou_density(bands.f, tau_s, interval_s)])
        own = own[:1] if walking else own
        seen = np.zeros((0, 0)) if output_axes is None else seen_density(output_axes, tau_s, interval_s, policy)
        total = np.maximum(np.average(density, axis=1, weights=bands.lines), LEAST_POWER)
        variance = np.repeat(total[:, None] / (len(own) + len(seen)), len(own), axis=1)
        turning = np.full(len(seen), variance.min())
        _fit(variance, turning, own, seen, density, bands.lines)
        white = np.maximum(variance[:, 0], LEAST_WHITE * total)
        return cls(tau_s, white, variance[:, 1:], turning, output_axes)

    def whitened(self, time_s: Array, usable: Array, columns: Array) -> tuple[Array, Array]:
        """Columns (n, q, w) as innovations over their standard deviation, and ln S (n, q) of the innovations.

        A Kalman filter with transition ``exp(-dt / tau_j)`` at the true times; unusable rows do not update the state.
        Outputs without a common wander are filtered one by one.
        """
        q = len(self.white)
        out, ln_S = np.empty_like(columns), np.empty(columns.shape[:2])
        for group in [slice(q)] if self.turning.size else [slice(a, a + 1) for a in range(q)]:
            out[:, group], ln_S[:, group] = self._innovations(time_s, usable, columns[:, group], group)
        return out, ln_S

    def _innovations(self, time_s: Array, usable: Array, columns: Array, group: slice) -> tuple[Array, Array]:
        """Innovations (n, q, w) and ln S (n, q) of a group of q outputs, by sequential updates of the outputs."""
        n, q, w = columns.shape
        tau_s, variance, seen = self._processes(n, group)
        processes, toward = (variance, 1 / tau_s, np.zeros(len(tau_s))), seen.reshape(n * q, -1)
        rows, white = columns.reshape(n * q, w), np.tile(self.white[group], n)
        out, ln_S = innovations(rows, toward, processes, np.repeat(time_s, q), white, np.repeat(usable, q))
        return out.reshape(n, q, w), ln_S.reshape(n, q)

    def _processes(self, n: int, group: slice) -> tuple[Array, Array, Array]:
        """Time constants (m,) and variances (m,) of all active processes, and how the outputs see them (n, q, m)."""
        slow, white = self.slow[group], self.white[group]
        whose, which = np.nonzero(slow > LEAST_SLOW * white[:, None])
        own = np.broadcast_to(np.arange(len(white))[:, None] == whose, (n, len(white), len(whose))).astype(np.float64)
        if self.output_axes is None or not self.turning.size:
            return self.tau_s[which], slow[whose, which], own
        turning = self.turning > LEAST_SLOW * white.min()
        tau_s = np.concatenate([self.tau_s[which], np.repeat(self.tau_s[turning], 3)])
        variance = np.concatenate([slow[whose, which], np.repeat(self.turning[turning], 3)])
        return tau_s, variance, np.concatenate([own, np.tile(self.output_axes, turning.sum())], axis=2)


def ou_density(f: Array, tau_s: Array, interval_s: float) -> Array:
    """Spectra (J, m) at frequencies f (m,) of sampled processes of variance one; white noise has 1 everywhere.

    ``(1 - a^2) / (1 - 2 a cos(2 pi f dt) + a^2)``, ``a = exp(-dt / tau)``.
    """
    a = np.exp(-interval_s / tau_s)[:, None]
    return np.asarray((1 - a**2) / (1 - 2 * a * np.cos(2 * np.pi * f * interval_s) + a**2))


def seen_density(output_axes: Array, tau_s: Array, interval_s: float, policy: Policy) -> Array:
    """Band means (J, q m) of the spectra of three independent unit processes projected on each of q axes u (n, q, 3).

    ``sum_l a^|l| C_l cos(2 pi f l dt) / sum h^2``, C the autocorrelation of ``h u`` and h the Hann window: the
    expectation of the windowed spectrum.
    """
    n, window = len(output_axes), hann(len(output_axes))
    C = np.fft.irfft(
        (np.abs(np.fft.rfft(output_axes * window[:, None], 2 * n, axis=0)) ** 2).sum(axis=2), 2 * n, axis=0
    )
    lag = np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n))
    kept = np.exp(-lag * interval_s / tau_s[:, None])
    spectra = np.fft.rfft(kept[:, None] * C.T)[:, :, ::2].real / (window**2).sum()
    means = [spectra[:, :, b].mean(axis=2) for b in even_bands(1, n // 2 + 1, policy.bands)]
    return np.stack(means, axis=2).reshape(len(tau_s), -1)


@fast_kernel
def _fit(variance: Array, turning: Array, own: Array, seen: Array, power: Array, lines: Array) -> None:
    """Update variances (q, p) of each output's own processes, with spectra (p, m), and (J,) of a wander that all see.

    seen (J, q m): spectra of the wander in the outputs, side by side; power (q, m) in bands of lines (m,).
    """
    (q, m), (p, J) = power.shape, (len(own), len(turning))
    down, up = np.zeros((q, m)), np.zeros((q, m))
    for _ in range(ROUNDS):
        for a in range(q):
            for b in range(m):
                S = LEAST_POWER
                for j in range(p):
                    S += variance[a, j] * own[j, b]
                for j in range(J):
                    S += turning[j] * seen[j, a * m + b]
                down[a, b] = lines[b] / S
                up[a, b] = down[a, b] * max(power[a, b], LEAST_POWER) / S
            for j in range(p):
                variance[a, j] *= np.dot(up[a], own[j]) / np.dot(down[a], own[j])
        for j in range(J):
            turning[j] *= np.dot(up.ravel(), seen[j]) / np.dot(down.ravel(), seen[j])
