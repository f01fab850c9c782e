"""Flicker noise in the residual of a fit of the field's strength: power, and effect on the fit.

r_i = a_i . n_i,  n the noise of the three measured components, a_i (3,) the derivative of the strength
"""

from __future__ import annotations

import numpy as np

from calib.numerics.colour import BLOCKS, LEAST_BLOCK, few_factor
from scenarios.arrays import Array
from scenarios.kernel_cache import njit

LOWEST_HZ = 1e-6
"""Where flicker noise is taken to end: eleven days, for as long as a calibration is used. What is slower is another
offset. In a recording of minutes it is 7 d^2 of each axis' variance, and 2.3 d^2 more with every tenth of it."""
SEEN = 2.5
"""Excess of the covariance at short lags, in its standard deviations under white noise, that is taken for flicker: one
white recording in 160, and what it is then claimed to be is small. At 3.0, 2 % of 200 runs of `tumble` of 120 s have
flicker noise that is missed, at 2.5 1.5 %."""
FREEDOM = 0.7
"""Degrees of freedom of the power d^2, in units of (d^2 / its standard deviation)^2: 2 for independent blocks, fewer
since flicker noise joins them. Of 120 runs of `tumble` of 120 s the claims of `ellipsoid` contain 91 % of the offsets,
those of `vector_least_squares` 97 %; with 2 they contain 84 and 95 %."""
FINER = 4
"""Frequencies a turn in the recording, at which the noise is summed: it is strongest where turns are few."""
MOST_PAIRS = 200_000
"""Pairs of samples that the mean logarithm of the lag is taken over."""


def flicker_power(r: Array, a: Array) -> tuple[float, float]:
    """d^2 of flicker noise of one-sided density d^2 / f, equal on the axes, in residuals r (n,) in order of time, and
    what a claim takes for d^2, larger by Student's t since d^2 is not known exactly.

    V_L = sum r_i r_j (a_i . a_j) / sum (a_i . a_j)^2 over all pairs i != j within blocks of L samples is the mean
    covariance of the noise over lags below L, whatever the motion. A fitted constant changes V_L equally at every L, up
    to the whole recording; flicker noise changes V_L by d^2 times the difference of the mean logarithms of the lags,
    equally weighted. Zero where the change is within chance. The deviation of d^2 is that of the blocks' mean.
    """
    blocks = next((blocks for blocks in (BLOCKS[1], BLOCKS[0]) if len(r) // blocks >= LEAST_BLOCK), None)
    if blocks is None:
        return 0.0, 0.0
    short = len(r) // blocks
    seen, counted = _pairs(r, a, short)
    (late, late_pairs), soon_pairs = (seen[-1], counted[-1]), float(counted[:blocks].sum())
    soon = float(seen[:blocks] @ counted[:blocks]) / soon_pairs
    chance = float(r @ r) / len(r) * np.sqrt(2.0 / late_pairs + 2.0 / soon_pairs)
    if not soon - late > SEEN * chance:
        return 0.0, 0.0
    std = float(np.linalg.norm(counted[:blocks] * (seen[:blocks] - soon))) / soon_pairs
    freedom = FREEDOM * ((soon - late) / std) ** 2 if std > 0 else np.inf
    power = float(soon - late) / (_mean_log_lag(a, len(r)) - _mean_log_lag(a, short))
    return power, power * few_factor(freedom)


@njit(cache=True, fastmath={"reassoc", "contract"})
def _pairs(r: Array, a: Array, length: int) -> tuple[Array, Array]:
    """V (m + 2,) of every block of a length, of the rest and of the whole, and sums of (a_i . a_j)^2 over its pairs.

    sum over i != j of r_i r_j a_i . a_j = |sum r a|^2 - sum r^2 |a|^2, and likewise of the squares
    """
    blocks = len(r) // length
    sums, total = np.empty(11), np.zeros(11)
    seen, pairs = np.zeros(blocks + 2), np.zeros(blocks + 2)
    for block in range(blocks + 1):
        sums[:] = 0.0
        for i in range(block * length, min((block + 1) * length, len(r))):
            x, y, z = a[i, 0], a[i, 1], a[i, 2]
            u, v, w = r[i] * x, r[i] * y, r[i] * z
            square = x * x + y * y + z * z
            sums[0], sums[1], sums[2] = sums[0] + u, sums[1] + v, sums[2] + w
            sums[3], sums[4], sums[5] = sums[3] + x * x, sums[4] + y * y, sums[5] + z * z
            sums[6], sums[7], sums[8] = sums[6] + x * y, sums[7] + x * z, sums[8] + y * z
            sums[9], sums[10] = sums[9] + r[i] * r[i] * square, sums[10] + square * square
        total += sums
        seen[block], pairs[block] = _of_sums(sums)
    seen[-1], pairs[-1] = _of_sums(total)
    return seen, pairs


@njit(cache=True)
def _of_sums(sums: Array) -> tuple[float, float]:
    """V and its pairs from the sums of r a (3,), of a a^T (6,), of r^2 |a|^2 and of |a|^4 over samples."""
    pull = (sums[:3] ** 2).sum() - sums[9]
    pairs = (sums[3:6] ** 2).sum() + 2.0 * (sums[6:9] ** 2).sum() - sums[10]
    return (pull / pairs if pairs > 0.0 else 0.0), pairs


def strength_and_axes(r: Array, a: Array) -> tuple[float, float]:
    """Evidence that r (n,) varies slowly with the strength of the field, and with noise n along the axes, r = a . n.

    sum r_i r_j s_ij / sqrt(sum s_ij^2) over pairs within blocks, s_ij = |a_i| |a_j| and a_i . a_j; in units of sigma^2.
    """
    length = len(r) // BLOCKS[0]
    strength = np.zeros_like(a)
    strength[:, 0] = np.sqrt(np.einsum("ni,ni->n", a, a))
    return _evidence(r, strength, length), _evidence(r, a, length)


def _evidence(r: Array, a: Array, length: int) -> float:
    """V_L sqrt(sum (a_i . a_j)^2) over the pairs within whole blocks of a length."""
    seen, pairs = (of_each[: len(r) // length] for of_each in _pairs(r, a, length))
    return float(seen @ pairs) / float(np.sqrt(pairs.sum()))


@njit(cache=True)
def _mean_log_lag(a: Array, length: int) -> float:
    """Mean of log |i - j| over the pairs within blocks of a length, weighted by (a_i . a_j)^2; of some, where many."""
    blocks = len(a) // length
    stride = max(1, int(np.ceil(np.sqrt(blocks * length**2 / 2.0 / MOST_PAIRS))))
    total, weight = 0.0, 0.0
    for first in range(0, blocks * length, length):
        for i in range(first, first + length, stride):
            for j in range(i + 1, first + length, stride):
                square = (a[i, 0] * a[j, 0] + a[i, 1] * a[j, 1] + a[i, 2] * a[j, 2]) ** 2
                weight += square
                total += square * np.log(j - i)
    return total / weight


def flicker_covariance(K: Array, rate_hz: float) -> Array:
    """Covariance (p, p) that flicker noise of density one at 1 Hz, on each axis, gives parameters sum_i K_i n_i.

    K (n, p, 3), in order of time at an even rate.  int S(f) k(f) k(f)^* df,  S = 1 / f from LOWEST_HZ on,  k the
    Fourier sum of K; what is slower than an eighth of a turn in the recording is a constant there.
    """
    n = FINER * len(K)
    m = np.arange(1, n // 2 + 1)
    slow = np.log(max(rate_hz / (2.0 * n * LOWEST_HZ), 1.0))
    share = np.sqrt(np.concatenate(([slow], np.log((m + 0.5) / (m - 0.5)))))
    total = np.zeros((K.shape[1], K.shape[1]))
    for axis in range(3):
        k = np.fft.rfft(K[:, :, axis], n, axis=0) * share[:, None]
        total += (k.T @ k.conj()).real
    return total
