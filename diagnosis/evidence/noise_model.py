"""Noise model of a residual: white noise plus Ornstein-Uhlenbeck processes, and the whitening Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence
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
    def of(
        cls,
        residual: Array,
        interval_s: float,
        policy: Policy,
        output_axes: Array | None = None,
        *,
        walking: bool = False,
    ) -> NoiseModel:
        """Fit the variances to a residual (n, q) by the banded Whittle likelihood.

        ``min sum_b a_b (ln S_b + P_b / S_b)`` over bands b of a_b lines under a Hann window, S the sum of the
        processes' spectra; each update multiplies a variance by ``sum a P s / S^2 / sum a s / S``. walking : white
        noise and a random walk of the axes alone.
        """
        shortest_s, longest_s = interval_s * policy.shortest_memory, interval_s * policy.longest_memory * len(residual)
        tau_s = np.geomspace(shortest_s, longest_s, policy.memories)[-1 if walking else 0 :]
        # a random walk over the whole run has most power in the first line, and would else be taken for a drift
        bands = Bands.of(residual, interval_s, 1, policy.bands)
        own, power = np.ones((1, len(bands.f))), bands.density / (2 * interval_s)
        if not walking:
            own = np.concatenate([own, ou_density(bands.f, tau_s, interval_s)])
        total, turning = residual.var(axis=0), np.zeros(0)
        if output_axes is None:
            variance = _fitted(np.repeat(total[:, None] / len(own), len(own), axis=1), own, power, bands.lines)
        else:
            seen = [seen_density(axis, tau_s, interval_s, policy) for axis in output_axes.swapaxes(0, 1)]
            variance, turning = _with_wander(own, total, seen, power, bands.lines)
        white = np.maximum(variance[:, 0], LEAST_WHITE * np.maximum(total, LEAST_POWER))
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


def _with_wander(own: Array, total: Array, seen: Sequence[Array], power: Array, lines: Array) -> tuple[Array, Array]:
    """Variances (q, p) of each output's own processes with spectra (p, m), and (J,) of a wander with q spectra (J, m).

    One likelihood of all outputs of variance total (q,), with powers (q, m) in bands of lines (m,).
    """
    q, p, J = len(total), len(own), len(seen[0])
    shapes = np.concatenate([np.kron(np.eye(q), own), np.concatenate(seen, axis=1)])
    start = np.append(np.repeat(total / (p + J), p), np.full(J, total.min() / (p + J)))
    variance = _fitted(start[None], shapes, power.reshape(1, -1), np.tile(lines, q))
    return variance[0, : q * p].reshape(q, p), variance[0, q * p :]


def ou_density(f: Array, tau_s: Array, interval_s: float) -> Array:
    """Spectra (J, m) at frequencies f (m,) of sampled processes of variance one; white noise has 1 everywhere.

    ``(1 - a^2) / (1 - 2 a cos(2 pi f dt) + a^2)``, ``a = exp(-dt / tau)``.
    """
    a = np.exp(-interval_s / tau_s)[:, None]
    return np.asarray((1 - a**2) / (1 - 2 * a * np.cos(2 * np.pi * f * interval_s) + a**2))


def seen_density(output_axes: Array, tau_s: Array, interval_s: float, policy: Policy) -> Array:
    """Band means (J, m) of the spectrum of three independent unit processes projected on an axis u (n, 3).

    ``sum_l a^|l| C_l cos(2 pi f l dt) / sum h^2``, C the autocorrelation of ``h u`` and h the Hann window: the
    expectation of the windowed spectrum.
    """
    n, window = len(output_axes), hann(len(output_axes))
    C = np.fft.irfft((np.abs(np.fft.rfft(output_axes * window, 2 * n, axis=0)) ** 2).sum(axis=1), 2 * n)
    lag = np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n))
    spectra = np.fft.rfft(np.exp(-lag * interval_s / tau_s[:, None]) * C)[:, ::2].real / (window**2).sum()
    return np.stack([spectra[:, b].mean(axis=1) for b in even_bands(1, n // 2 + 1, policy.bands)], axis=1)


@fast_kernel
def _fitted(start: Array, shapes: Array, power: Array, lines: Array) -> Array:
    """Variances (q, p) after all updates, of processes with spectra (p, m), for powers (q, m) of m bands of lines."""
    variance = start.copy()
    q, m = power.shape
    p = len(shapes)
    up, down = np.zeros(m), np.zeros(m)
    for a in range(q):
        for _ in range(ROUNDS):
            for b in range(m):
                S = 0.0
                for j in range(p):
                    S += variance[a, j] * shapes[j, b]
                S = max(S, LEAST_POWER)
                down[b] = lines[b] / S
                up[b] = down[b] * max(power[a, b], LEAST_POWER) / S
            for j in range(p):
                more, less = 0.0, 0.0
                for b in range(m):
                    more += up[b] * shapes[j, b]
                    less += down[b] * shapes[j, b]
                variance[a, j] *= more / less
    return variance
