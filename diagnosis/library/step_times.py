"""The moment of a step: every sample tried at once."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array

Sums = tuple[Array, Array, Array]
PIECE = 20_000
"""Samples whose products are held at once."""
OWN_NOISE = 10.0
"""Times a direction's own noise that it must move for a step to be seen through it: below, noise is fitted to noise."""


def moments(problem: LinearProblem, residual: Array, member: Candidate) -> list[Candidate]:
    """The best moment of a step in a residual (n, q) that the base has been fitted to."""
    name = member.effect.with_role("moment")
    assert name is not None
    left = _without_base(problem, residual)
    if problem.mode == "vector":
        best = int(np.argmax(_gains(problem, left)))
    else:
        best = _best_along_field(problem, left, member)
    return [member.at({name: float(problem.state.time_s[best])}, len(left))]


def _without_base(problem: LinearProblem, residual: Array) -> Array:
    B = problem.base.reshape(-1, problem.base.shape[-1])
    y = residual.reshape(len(B), -1)
    return np.asarray(y - B @ (_inverse(problem) @ (B.T @ y))).reshape(residual.shape)


def _inverse(problem: LinearProblem) -> Array:
    B = problem.base.reshape(-1, problem.base.shape[-1])
    return np.asarray(np.linalg.pinv(B.T @ B, rcond=1e-13, hermitian=True))


def _gains(problem: LinearProblem, left: Array) -> Array:
    """Squares (n,) that a step at each moment explains beside the base, from suffix sums.

    ``gain_t = |sum_{s >= t} y_s|^2 / (n_t - b_t^T (B^T B)^-1 b_t)`` with ``n_t, b_t`` the sums of 1 and B from t on.
    """
    beyond_B, beyond_1, beyond_y = (_suffix_sums(v) for v in (problem.base, problem.usable, left))
    size = beyond_1 - np.einsum("np,pr,nr->n", beyond_B, _inverse(problem), beyond_B)
    gain = (beyond_y**2).sum(axis=1) / np.maximum(size, 1e-9)
    gain[size < problem.policy.step_margin * size.max()] = 0.0
    return np.asarray(gain)


def _best_along_field(problem: LinearProblem, left: Array, member: Candidate) -> int:
    """The sample of the best step that is seen through the field's direction, beside the base."""
    gain = _gains_along_field(problem, left, member.columns(problem))
    edge = max(2, int(len(left) * problem.policy.step_margin))
    return edge + int(np.argmax(gain[edge:-edge]))


def _gains_along_field(problem: LinearProblem, left: Array, E: Array) -> Array:
    """Squares (n,) that a step at each moment explains beside the base, of columns E (n, q, k) that begin there.

    ``gain_t = z' (E'E - E'B (B'B)^-1 B'E)^-1 z`` with ``z = E'y``, all sums from t on: on long legs iron takes up much
    of a step, and more of one at the wrong moment. The direction is a measurement too: where a short stretch at rest
    holds nothing else, its noise is that of the strength, and what it holds is weighed down.
    From the end in pieces, for all products at once fill the memory.
    """
    n, q, k = E.shape
    gain, either, own = np.zeros(n), _in_the_shorter_part(problem.usable), _own_noise(problem, E)
    B = problem.base.reshape(n, q, -1)  # of one output, or with the coefficients in common
    beyond: Sums = (np.zeros(k), np.zeros((k, k)), np.zeros((B.shape[2], k)))
    for end in range(n, 0, -PIECE):
        here = slice(max(end - PIECE, 0), end)
        y, EE, BE = _summed(B[here], E[here], left[here], beyond)
        free = EE - np.einsum("npi,pr,nrj->nij", BE, _inverse(problem), BE, optimize=True)
        free += (either[here] * own)[:, None, None] * np.eye(k)
        gain[here] = np.einsum("nk,nk->n", y, np.linalg.solve(free, y[:, :, None])[:, :, 0])
        beyond = (y[0], EE[0], BE[0])
    return gain


def _summed(B: Array, E: Array, left: Array, beyond: Sums) -> Sums:
    """``E'y, E'E, B'E`` (m, ...) of all samples from each of these on, with what is summed beyond the last."""
    y, EE, BE = beyond
    return (
        y + _suffix_sums(np.einsum("nqk,nq->nk", E, left)),
        EE + _suffix_sums(np.einsum("nqi,nqj->nij", E, E)),
        BE + _suffix_sums(np.einsum("nqp,nqk->npk", B, E)),
    )


def _in_the_shorter_part(usable: Array) -> Array:
    """Samples (n,) before or from each moment on, whichever are fewer, and one."""
    after = _suffix_sums(usable)
    return np.asarray(np.minimum(after, after[0] - after) + 1.0)


def _own_noise(problem: LinearProblem, E: Array) -> float:
    """Square of what the noise of a measured direction makes in a column, times that of `OWN_NOISE`."""
    noise = float(problem.sigma_nT[0] / np.linalg.norm(problem.state.field_nT[0]))
    return (OWN_NOISE * noise) ** 2 * float((E**2).sum(axis=1).mean())


def _suffix_sums(values: Array) -> Array:
    return np.cumsum(values[::-1], axis=0)[::-1]
