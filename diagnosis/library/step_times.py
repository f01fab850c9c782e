"""Time search for a step: every sample compared."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array

Sums = tuple[Array, Array, Array]
PIECE = 20_000
"""Samples processed at once."""
OWN_NOISE = 10.0
"""Ratio to the noise of the measured direction below which a step along the direction is noise fitted to noise."""
LEAST_SHARE = 1e-10
"""Least share of a column's mean square that the own noise counts for: with less, rounding decides where iron explains
a step at every time, as at constant attitude."""


def find_moments(problem: LinearProblem, residual: Array, candidate: Candidate) -> list[Candidate]:
    """The candidate at the best step time for a residual (n, q) of the fitted base."""
    name = candidate.effect.with_role("moment")
    assert name is not None
    B = problem.base.reshape(-1, problem.base.shape[-1])
    y = residual.reshape(len(B), -1)
    free = np.asarray(y - B @ (_inverse(problem) @ (B.T @ y))).reshape(residual.shape)
    if problem.mode == "vector":
        best = int(np.argmax(_gains(problem, free)))
    else:
        edge = max(2, int(len(free) * problem.policy.step_margin))
        best = edge + int(np.argmax(_gains_along_field(problem, free, candidate.columns(problem))[edge:-edge]))
    return [candidate.at({name: float(problem.state.time_s[best])}, len(free))]


def _inverse(problem: LinearProblem) -> Array:
    B = problem.base.reshape(-1, problem.base.shape[-1])
    return np.asarray(np.linalg.pinv(B.T @ B, rcond=1e-13, hermitian=True))


def _gains(problem: LinearProblem, residual: Array) -> Array:
    """Squares (n,) that a step at each time explains beside the base, from suffix sums.

    ``gain_t = |sum_{s >= t} y_s|^2 / (n_t - b_t^T (B^T B)^-1 b_t)``, n_t and b_t the sums of 1 and B from t on.
    """
    beyond_B, beyond_1, beyond_y = (_suffix_sums(v) for v in (problem.base, problem.usable, residual))
    size = beyond_1 - np.einsum("np,pr,nr->n", beyond_B, _inverse(problem), beyond_B)
    gain = (beyond_y**2).sum(axis=1) / np.maximum(size, 1e-9)
    gain[size < problem.policy.step_margin * size.max()] = 0.0
    return np.asarray(gain)


def _gains_along_field(problem: LinearProblem, residual: Array, E: Array) -> Array:
    """Squares (n,) that a step at each time explains beside the base, with columns E (n, q, k) that begin at the step.

    ``gain_t = z' (E'E - E'B (B'B)^-1 B'E)^-1 z``, ``z = E'y``, all sums from t on: on long legs iron absorbs much of a
    step, and more of a step at the wrong time. At a constant attitude iron absorbs all of it: the inverse is the
    pseudo-inverse. The direction is a measurement too, with noise like the strength's: the
    diagonal term keeps a short section at rest from explaining noise by noise. Computed in pieces from the end, to
    limit memory.
    """
    n, q, k = E.shape
    gain, either, own = np.zeros(n), _in_the_shorter_part(problem.usable), _own_noise(problem, E)
    B = problem.base.reshape(n, q, -1)  # of one output, or with the coefficients in common
    beyond: Sums = (np.zeros(k), np.zeros((k, k)), np.zeros((B.shape[2], k)))
    for end in range(n, 0, -PIECE):
        here = slice(max(end - PIECE, 0), end)
        y, EE, BE = _summed(B[here], E[here], residual[here], beyond)
        free = EE - np.einsum("npi,pr,nrj->nij", BE, _inverse(problem), BE, optimize=True)
        free += (either[here] * own)[:, None, None] * np.eye(k)
        gain[here] = np.einsum("nk,nkj,nj->n", y, np.linalg.pinv(free, hermitian=True), y)
        beyond = (y[0], EE[0], BE[0])
    return gain


def _summed(B: Array, E: Array, residual: Array, beyond: Sums) -> Sums:
    """``E'y, E'E, B'E`` (m, ...) from each sample to the end; `beyond`: sums after the last sample."""
    y, EE, BE = beyond
    return (
        y + _suffix_sums(np.einsum("nqk,nq->nk", E, residual)),
        EE + _suffix_sums(np.einsum("nqi,nqj->nij", E, E)),
        BE + _suffix_sums(np.einsum("nqp,nqk->npk", B, E)),
    )


def _in_the_shorter_part(usable: Array) -> Array:
    """Number of samples (n,) before or after each time, whichever is smaller, plus 1."""
    after = _suffix_sums(usable)
    return np.asarray(np.minimum(after, after[0] - after) + 1.0)


def _own_noise(problem: LinearProblem, E: Array) -> float:
    """Square of the noise of a measured direction in a column, times the square of `OWN_NOISE`, or `LEAST_SHARE`."""
    noise = float(problem.sigma_nT[0] / np.linalg.norm(problem.state.field_nT[0]))
    return max((OWN_NOISE * noise) ** 2, LEAST_SHARE) * float((E**2).sum(axis=1).mean())


def _suffix_sums(values: Array) -> Array:
    return np.cumsum(values[::-1], axis=0)[::-1]
