"""The moment of a step: every sample tried at once."""

from __future__ import annotations

import numpy as np

from sim.state import Array
from validation.diagnosis.library.candidates import Candidate
from validation.diagnosis.problem.linear import LinearProblem


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
    B = problem.base
    return np.asarray(residual - B @ (_inverse(problem) @ (B.T @ residual)))


def _inverse(problem: LinearProblem) -> Array:
    B = problem.base
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
    """The sample of the best step that is seen through the field's direction: suffix sums of direction times y."""
    beyond = _suffix_sums(member.columns(problem)[:, 0, :] * left)
    n = len(left)
    count = np.arange(n, 0, -1)
    gain = (beyond**2).sum(axis=1) / count / (1 - count / (n + 1))
    edge = max(2, int(n * problem.policy.step_margin))
    return edge + int(np.argmax(gain[edge:-edge]))


def _suffix_sums(values: Array) -> Array:
    return np.cumsum(values[::-1], axis=0)[::-1]
