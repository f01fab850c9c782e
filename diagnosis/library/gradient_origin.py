"""Origin of a field linear in position: a change of the origin adds a constant field."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import Cut, fit, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def find_origins(problem: LinearProblem, residual: Array, candidate: Candidate) -> list[Candidate]:
    """The given origin, and the least-squares origin for a residual (n, q).

    ``R_wb^T (G (p - m) + c)`` is linear in G and in the constant c, m the mean position; the field vanishes at ``m +
    d`` with ``G d = -c``. Search price: at least as many positions as the dipole search compares.
    """
    name = candidate.effect.with_role("origin")
    assert name is not None
    middle = problem.state.pos_enu_m.mean(axis=0)
    about = candidate.at({name: tuple(map(float, middle))})
    G, c = _with_constant(problem, residual, about)
    place = middle + _shift(G, c, problem.state.field_enu_nT)
    low, high = next((p.low, p.high) for p in candidate.effect.parameters() if p.name == name)
    if not (np.isfinite(place).all() and (place >= low).all() and (place <= high).all()):
        return [candidate]
    return [candidate, candidate.at({name: tuple(map(float, place))}, problem.policy.place_cells**3)]


def _with_constant(problem: LinearProblem, residual: Array, about: Candidate) -> tuple[Array, Array]:
    """Least-squares matrix G (3, 3) and constant c (3,) beside the base."""
    linear, constant = about.columns(problem), problem.whitened(problem.state.R_wb.transpose(0, 2, 1), about.effect)
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    s = sums(cut, problem.base, np.concatenate([linear, constant], axis=2), residual, problem.usable)
    found = fit(s, s.all_folds).c
    G = sum(value * unit for value, (_, unit) in zip(found[:-3], about.effect.linear_units(), strict=True))
    return np.asarray(G), found[-3:]


def _shift(G: Array, c: Array, field_enu_nT: Array) -> Array:
    """Shortest d (3,) with G d = -c across the field; along the field c is a scale, absorbed by the base."""
    along = field_enu_nT / np.linalg.norm(field_enu_nT)
    across = np.eye(3) - np.outer(along, along)
    return np.asarray(-np.linalg.pinv(across @ G, rcond=1e-9) @ (across @ c))
