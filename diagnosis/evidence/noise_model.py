"""What a hypothesis leaves: white noise and slow processes of several memories, and the filter that whitens it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from calib.numerics.innovations import innovations
from calib.numerics.kernels import fast_kernel
from diagnosis.policy import Policy
from scenarios.arrays import Array
from validation.signals.bands import even_bands, hann

ROUNDS = 3000
"""Updates of the variances: after them a random walk's likelihood is within a nat of its limit."""
LEAST_WHITE = 1e-3
"""Share of the residual's variance that is white at the least: a filter without white noise interpolates."""
LEAST_SLOW = 1e-7
"""Variance over the white one below which a process is not there."""
LEAST_POWER = 1e-12
"""The least power of a band: a log may have rows of none."""
SAME_STEP, SETTLED = 1e-6, 1e-12
"""Relative difference of steps that are one, and the change of a gain that is constant from there on."""


@dataclass(frozen=True)
class NoiseModel:
    """``r = white + sum_j OU(tau_j)`` of q outputs: variances `white` (q,) and `slow` (q, J), memories `tau_s` (J,).

    Where the outputs are parts of a vector, seen by `sight` (n, q, 3), also ``sight . (OU_x, OU_y, OU_z)(tau_j)``: a
    wander of the sensor's axes, of variances `turning` (J,), which comes and goes with the motion. The outputs see one
    wander.
    """

    tau_s: Array
    white: Array
    slow: Array
    turning: Array = field(default_factory=lambda: np.zeros(0))
    sight: Array | None = None

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy, sight: Array | None = None) -> NoiseModel:
        """The variances of greatest banded Whittle likelihood for a residual (n, q).

        ``sum_b a_b (ln S_b + P_b / S_b)`` over bands b of a_b lines under a Hann window, S the sum of the processes'
        spectra; every update multiplies a variance by ``sum a P s / S^2 / sum a s / S``.
        """
        n = len(residual)
        tau_s = np.geomspace(
            policy.shortest_memory * interval_s, policy.longest_memory * n * interval_s, policy.memories
        )
        f, power, lines = _bands(residual, interval_s, policy)
        own = np.concatenate([np.full((1, len(f)), 1.0), ou_density(f, tau_s, interval_s)])
        total = residual.var(axis=0)
        if sight is None:
            variance, turning = _fitted(_even(total, len(own)), own, power, lines), np.zeros(0)
        else:
            variance, turning = _with_wander(own, total, seen_densities(sight, tau_s, interval_s, policy), power, lines)
        white = np.maximum(variance[:, 0], LEAST_WHITE * np.maximum(total, 1e-300))
        return cls(tau_s, white, variance[:, 1:], turning, sight)

    @classmethod
    def walking(cls, residual: Array, interval_s: float, policy: Policy, sight: Array) -> NoiseModel:
        """White noise of each output and a random walk of the axes alone, of greatest likelihood likewise."""
        tau_s = np.array([policy.longest_memory * len(residual) * interval_s])
        f, power, lines = _bands(residual, interval_s, policy)
        total, seen = residual.var(axis=0), seen_densities(sight, tau_s, interval_s, policy)
        variance, turning = _with_wander(np.ones((1, len(f))), total, seen, power, lines)
        white = np.maximum(variance[:, 0], LEAST_WHITE * np.maximum(total, 1e-300))
        return cls(tau_s, white, np.zeros((len(total), 1)), turning, sight)

    def whitened(self, time_s: Array, usable: Array, columns: Array) -> tuple[Array, Array]:
        """Columns (n, q, w) as innovations over their standard deviation, and ln S (n, q) of the innovations.

        A Kalman filter with transition exp(-dt / tau_j) at the true times; rows that are not usable teach nothing.
        """
        if self.sight is not None and self.turning.size:
            return self._whitened_together(self.sight, time_s, usable, columns)
        out, ln_S = np.zeros(columns.shape), np.zeros(columns.shape[:2])
        for a, (white, slow) in enumerate(zip(self.white, self.slow, strict=True)):
            there = slow > LEAST_SLOW * white
            one, ln = _filter(time_s, usable, columns[:, a].copy(), self.tau_s[there], slow[there], float(white))
            out[:, a], ln_S[:, a] = one, ln
        return out, ln_S

    def _whitened_together(self, sight: Array, time_s: Array, usable: Array, columns: Array) -> tuple[Array, Array]:
        """The same where outputs see one wander of three axes: of a row one after the other, over their white noise."""
        n, q, w = columns.shape
        tau_s, variance, seen = self._processes(sight)
        root = np.sqrt(self.white)[:, None]
        decay = np.ones((n, q, len(tau_s)))
        decay[1:, 0] = np.exp(-np.diff(time_s)[:, None] / tau_s)
        steps = decay.reshape(n * q, -1)[1:]
        processes = (variance, steps, (1 - steps**2) * variance)
        each, toward = (np.reshape(one / root, (n * q, -1)) for one in (columns, seen))
        out, ln_S = innovations(each, toward, processes, 1.0, np.repeat(usable, q))
        there = (usable > 0)[:, None]
        return out.reshape(n, q, w), ln_S.reshape(n, q) + there * np.log(self.white)

    def _processes(self, sight: Array) -> tuple[Array, Array, Array]:
        """Memories (m,) and variances (m,) of all processes that are there, and how outputs see them (n, q, m)."""
        n, q, _ = sight.shape
        slow, turning = self.slow > LEAST_SLOW * self.white[:, None], self.turning > LEAST_SLOW * self.white.min()
        whose, which = np.nonzero(slow)
        tau_s = np.concatenate([self.tau_s[which], np.repeat(self.tau_s[turning], 3)])
        variance = np.concatenate([self.slow[slow], np.repeat(self.turning[turning], 3)])
        own = np.broadcast_to(np.arange(q)[:, None] == whose, (n, q, len(whose)))
        return tau_s, variance, np.concatenate([own, np.tile(sight, turning.sum())], axis=2)


def _even(total: Array, p: int) -> Array:
    """Variances (q, p) of p processes that share those of q outputs evenly."""
    return np.repeat(total[:, None] / p, p, axis=1)


def _with_wander(own: Array, total: Array, seen: Array, power: Array, lines: Array) -> tuple[Array, Array]:
    """Variances (q, J + 1) of each output's own processes (J + 1, m), and (J,) of a wander that it sees as (q, J, m).

    One likelihood of all outputs, with powers (q, m) in bands of lines (m,).
    """
    (q, J, m), p = seen.shape, len(own)
    shapes = np.zeros((q * p + J, q * m))
    for a in range(q):
        shapes[a * p : (a + 1) * p, a * m : (a + 1) * m] = own
        shapes[q * p :, a * m : (a + 1) * m] = seen[a]
    start = _even(total, p + J)[:, :p].ravel()
    variance = _fitted(np.append(start, np.full(J, start.min()))[None], shapes, power.reshape(1, -1), np.tile(lines, q))
    return variance[0, : q * p].reshape(q, p), variance[0, q * p :]


def ou_density(f: Array, tau_s: Array, interval_s: float) -> Array:
    """Spectra (J, m) at frequencies f (m,) of sampled processes of variance one; white noise has 1 everywhere.

    ``(1 - a^2) / (1 - 2 a cos(2 pi f dt) + a^2)``, ``a = exp(-dt / tau)``.
    """
    a = np.exp(-interval_s / tau_s)[:, None]
    return np.asarray((1 - a**2) / (1 - 2 * a * np.cos(2 * np.pi * f * interval_s) + a**2))


def seen_densities(sight: Array, tau_s: Array, interval_s: float, policy: Policy) -> Array:
    """The same (q, J, m) of each of q outputs, seen by (n, q, 3)."""
    return np.stack([seen_density(one, tau_s, interval_s, policy) for one in sight.swapaxes(0, 1)])


def seen_density(sight: Array, tau_s: Array, interval_s: float, policy: Policy) -> Array:
    """Spectra (J, m) in the bands of three independent processes of variance one, seen by (n, 3).

    ``sum_l a^|l| C_l cos(2 pi f l dt) / sum h^2`` with C the autocorrelation of ``h u``, h the Hann window: what the
    windowed spectrum is expected to be.
    """
    n, window = len(sight), hann(len(sight))
    C = np.fft.irfft((np.abs(np.fft.rfft(sight * window, 2 * n, axis=0)) ** 2).sum(axis=1), 2 * n)
    lag = np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n))
    spectra = np.fft.rfft(np.exp(-lag * interval_s / tau_s[:, None]) * C)[:, ::2].real / (window**2).sum()
    return np.stack([spectra[:, b].mean(axis=1) for b in even_bands(1, n // 2 + 1, policy.bands)], axis=1)


def _bands(residual: Array, interval_s: float, policy: Policy) -> tuple[Array, Array, Array]:
    """Frequencies (m,), power (q, m) with white noise at its variance, and independent lines (m,) of bands in log f.

    From the first line on: the course of a random walk over the whole run stands there, and would else be a drift.
    """
    n = len(residual)
    window = hann(n)
    power = np.abs(np.fft.rfft((residual - residual.mean(axis=0)) * window, axis=0)) ** 2 / (window**2).sum()
    band = even_bands(1, len(power), policy.bands)
    f = np.fft.rfftfreq(n, interval_s)
    lines = np.array([b.stop - b.start for b in band], dtype=np.float64)
    means = np.stack([power[b].mean(axis=0) for b in band], axis=1)
    return np.array([f[b].mean() for b in band]), np.maximum(means, LEAST_POWER), lines


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
                up[b] = down[b] * power[a, b] / S
            for j in range(p):
                more, less = 0.0, 0.0
                for b in range(m):
                    more += up[b] * shapes[j, b]
                    less += down[b] * shapes[j, b]
                variance[a, j] *= more / less
    return variance


@fast_kernel
def _filter(
    time_s: Array, usable: Array, columns: Array, tau_s: Array, slow: Array, white: float
) -> tuple[Array, Array]:
    """Innovations e / sqrt(S) (n, w) of columns y (n, w), and ln S (n,), of one output.

    ``x_j' = a_j x_j``, ``P' = a a^T P + diag((1 - a^2) v)``, ``a_j = exp(-dt / tau_j)``, v the slow variances;
    ``e = y - sum x``, ``S = white + sum P``, ``K = P 1 / S``, ``x' = x + K e``, ``P' = P - K K^T S``. At equal steps
    K settles, and P is not followed from there on. One loop: calls for its parts cost a fifth of its time.
    """
    n, w = columns.shape
    J = len(tau_s)
    P, x = np.diag(slow), np.zeros((J, w))
    gain, kept = np.zeros(J), np.zeros(J)
    out, ln_S = np.zeros((n, w)), np.zeros(n)
    S, last_s, settled = white, -1.0, False
    for i in range(n):
        if i > 0:
            step_s = time_s[i] - time_s[i - 1]
            settled = settled and abs(step_s - last_s) < SAME_STEP * step_s and usable[i] > 0
            if not settled:
                kept[:] = np.exp(-step_s / tau_s)
                last_s = step_s
                for j in range(J):
                    for k in range(J):
                        P[j, k] *= kept[j] * kept[k]
                    P[j, j] += (1 - kept[j] * kept[j]) * slow[j]
            for j in range(J):
                for c in range(w):
                    x[j, c] *= kept[j]
        if usable[i] == 0:
            continue
        if not settled:
            S = white + P.sum()
            change = 0.0
            for j in range(J):
                new = P[j].sum() / S
                change = max(change, abs(new - gain[j]))
                gain[j] = new
            for j in range(J):
                for k in range(J):
                    P[j, k] -= gain[j] * gain[k] * S
            settled = i > 0 and change < SETTLED
        ln_S[i] = np.log(S)
        for c in range(w):
            e = columns[i, c]
            for j in range(J):
                e -= x[j, c]
            out[i, c] = e / np.sqrt(S)
            for j in range(J):
                x[j, c] += gain[j] * e
    return out, ln_S
