"""The origin of a field that is linear in the place: with another origin it is the same field and a constant."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import Cut, fit, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.base import Effect


def origins(problem: LinearProblem, residual: Array, member: Candidate) -> list[Candidate]:
    """The given origin, and the one that fits a residual (n, q) best.

    ``R_wb^T (G (p - m) + c)`` is linear in G and in the constant c, m the path's middle; it vanishes at ``m + d`` with
    ``G d = -c``. Price: as many places are compared as the search of a place looks at, at least.
    """
    name = member.effect.with_role("origin")
    assert name is not None
    middle = problem.state.pos_enu_m.mean(axis=0)
    about = member.at({name: tuple(map(float, middle))})
    G, c = _with_constant(problem, residual, about)
    place = middle + _shift(G, c, problem.state.field_enu_nT)
    low, high = next((p.low, p.high) for p in member.effect.parameters() if p.name == name)
    if not (np.isfinite(place).all() and (place >= low).all() and (place <= high).all()):
        return [member]
    return [member, member.at({name: tuple(map(float, place))}, problem.policy.place_cells**3)]


def _with_constant(problem: LinearProblem, residual: Array, about: Candidate) -> tuple[Array, Array]:
    """Matrix G (3, 3) and constant c (3,) of least squares beside the base."""
    linear = about.columns(problem)
    constant = problem.whitened(problem.state.R_wb.transpose(0, 2, 1), about.effect)
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    s = sums(cut, problem.base, np.concatenate([linear, constant], axis=2), residual, problem.usable)
    found = fit(s, s.everything).c
    return _matrix(about.effect, found[:-3]), found[-3:]


def _matrix(effect: type[Effect], coefficients: Array) -> Array:
    """Sum (3, 3) of the unit values of the one linear parameter."""
    return np.asarray(sum(c * unit for c, (_, unit) in zip(coefficients, effect.linear_units(), strict=True)))


def _shift(G: Array, c: Array, field_enu_nT: Array) -> Array:
    """Shortest d (3,) with G d = -c across the field; what c has along it is a scale that the base takes up."""
    along = field_enu_nT / np.linalg.norm(field_enu_nT)
    across = np.eye(3) - np.outer(along, along)
    return np.asarray(-np.linalg.pinv(across @ G, rcond=1e-9) @ (across @ c))
