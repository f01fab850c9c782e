"""The least-squares fits that [Zhang2018] refers to, on one quadric: ordinary, total and recursive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib.models.quadric import design, shape_matrix
from papers.base import PaperRow, spread_text
from papers.judgement import incomparable
from papers.zhang2018.trials import SEED, effects, spiral, strength_nT, true_offset_nT
from scenarios.arrays import Array
from sim.chain import Chain

LOOSE = 1e8
"""Prior variance of the recursion's parameters, so large that the batch's solution remains."""


def ordinary(rows: Array) -> Array:
    """Return theta (9,) of least |rows theta - 1|."""
    return np.asarray(np.linalg.lstsq(rows, np.ones(len(rows)), rcond=None)[0], dtype=np.float64)


def total(rows: Array) -> Array:
    """Return theta (9,) by total least squares: the weakest right singular vector of (rows, -1), scaled to end in 1."""
    weakest = np.linalg.svd(np.column_stack((rows, -np.ones(len(rows)))), full_matrices=False)[2][-1]
    return np.asarray(weakest[:9] / weakest[9], dtype=np.float64)


def recursive(rows: Array) -> Array:
    """Return theta (9,) sample by sample: gain K = P d / (1 + d^T P d), theta + K (1 - d^T theta), P - K d^T P."""
    theta, P = np.zeros(rows.shape[1]), LOOSE * np.eye(rows.shape[1])
    for d in rows:
        Pd = P @ d
        gain = Pd / (1.0 + d @ Pd)
        theta = theta + gain * (1.0 - d @ theta)
        P = P - np.outer(gain, Pd)
    return np.asarray(theta)


METHODS: dict[str, Callable[[Array], Array]] = {"ordinary": ordinary, "total": total, "recursive": recursive}


@dataclass(frozen=True)
class QuadricErrors:
    """Rms of |h| - F over the record and error of the hard iron, nT, by method."""

    rms_nT: dict[str, float]
    offset_nT: dict[str, float]


def least_squares_trial(seed: int) -> QuadricErrors:
    """Fit the excited spiral without drift by each method."""
    state, chain = spiral(True), effects(0.0)
    strength = strength_nT(state)
    x = Chain(chain, SEED, seed).apply(state)[0] / strength
    found = QuadricErrors({}, {})
    for name, method in METHODS.items():
        theta = method(design(x))
        A, p = shape_matrix(theta), theta[6:]
        centre = -np.linalg.solve(A, p)
        square = np.einsum("ni,ij,nj->n", x - centre, A, x - centre) / (1.0 - p @ centre)
        found.rms_nT[name] = strength * float(np.sqrt(np.mean((np.sqrt(square) - 1.0) ** 2)))
        found.offset_nT[name] = float(np.linalg.norm(strength * centre - true_offset_nT(chain)))
    return found


def least_squares_row(trials: list[QuadricErrors]) -> PaperRow:
    """Return the row on the three fits."""
    rms, offset = (
        "; ".join(f"{name} {spread_text([getattr(t, what)[name] for t in trials])} nT" for name in METHODS)
        for what in ("rms_nT", "offset_nT")
    )
    return PaperRow(
        "ordinary, total and recursive least squares of the quadric, excited spiral without drift: rms",
        "referred to, no figure",
        rms,
        incomparable("the paper names the fits and prints no figure of them"),
        f"error of the hard iron: {offset}. The recursion ends at the ordinary fit; the total fit takes the "
        "constant's column for noisy too",
    )
