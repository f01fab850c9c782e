"""Repeated rows and pauses: exclusions for noise estimates from neighbouring samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.linear import pauses_after, sample_noise
from scenarios.arrays import Array


def repeated(mag_nT: Array) -> NDArray[np.bool_]:
    """Mask (n,) of rows of values (n, 3) equal to the row before."""
    return np.asarray(np.concatenate([[False], (mag_nT[1:] == mag_nT[:-1]).all(axis=1)]), dtype=np.bool_)


def held(mag_nT: Array, residual: Array, policy: Policy) -> NDArray[np.bool_]:
    """Mask (n,) of repeated rows, where more frequent than rounding explains; left (n, q): residual without motion.

    Two values with noise s round to one step d of a lattice with probability ``d / (2 sqrt(pi) s)``, at most 1.
    """
    again = repeated(mag_nT)
    share = float(again.mean())
    if np.count_nonzero(again) < policy.least_spikes:
        return np.zeros(len(mag_nT), np.bool_)
    steps = np.array([np.diff(np.unique(axis)).min(initial=np.inf) for axis in mag_nT.T])
    chance = float(np.prod(np.minimum(1.0, steps / (2 * np.sqrt(np.pi) * sample_noise(residual)))))
    return again & (share > policy.much_larger * chance)


def noise_of_neighbours(residual: Array, mag_nT: Array, time_s: Array, policy: Policy) -> Array:
    """White noise (q,) of a residual (n, q) without motion, from rows that are not repeated, and not across pauses.

    From all rows where too few are new: a noiseless vehicle at rest repeats every row.
    """
    fresh = ~held(mag_nT, residual, policy)
    sigma = sample_noise(residual[fresh], pauses_after(time_s[fresh], policy))
    return sigma if np.isfinite(sigma).all() else sample_noise(residual, pauses_after(time_s, policy))
