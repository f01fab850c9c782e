"""Rows that repeat the row before because nothing new was measured, and pauses: what is no noise of neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.linear import pauses_after, sample_noise
from scenarios.arrays import Array


def repeated(mag_nT: Array) -> NDArray[np.bool_]:
    """Rows (n,) of values (n, 3) that repeat the row before."""
    return np.asarray(np.concatenate([[False], (mag_nT[1:] == mag_nT[:-1]).all(axis=1)]), dtype=np.bool_)


def held(mag_nT: Array, left: Array, policy: Policy) -> NDArray[np.bool_]:
    """Repeated rows (n,) where there are more of them than rounding explains; left (n, q): values without the motion.

    Two values of noise s fall on one step d of a lattice with the chance ``d / (2 sqrt(pi) s)``, at most 1.
    """
    again = repeated(mag_nT)
    share = float(again.mean())
    if share <= policy.held_rows:
        return np.zeros(len(mag_nT), np.bool_)
    steps = np.array([np.diff(np.unique(axis)).min(initial=np.inf) for axis in mag_nT.T])
    chance = float(np.prod(np.minimum(1.0, steps / (2 * np.sqrt(np.pi) * sample_noise(left)))))
    return again & (share > policy.held_odds * chance)


def noise_of_neighbours(left: Array, mag_nT: Array, time_s: Array, policy: Policy) -> Array:
    """White noise (q,) of values without the motion (n, q): of rows that are not held, and not across a pause.

    Of all rows where too few are fresh: without noise a vehicle at rest repeats them all.
    """
    fresh = ~held(mag_nT, left, policy)
    sigma = sample_noise(left[fresh], pauses_after(time_s[fresh], policy))
    return sigma if np.isfinite(sigma).all() else sample_noise(left, pauses_after(time_s, policy))
