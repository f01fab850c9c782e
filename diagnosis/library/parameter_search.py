"""Values of nonlinear parameters that a short list cannot hold: found by a search, or between the listed ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from diagnosis.library.candidates import Candidate
from diagnosis.library.dipole_position import places
from diagnosis.library.gradient_origin import origins
from diagnosis.library.ripple_frequency import tones
from diagnosis.library.step_times import moments
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array

Search = Callable[[LinearProblem, Array, Candidate], list[Candidate]]
"""(problem, residual (n, q) that the base and the effects already in leave, candidate) -> candidates with values."""
SEARCHES: dict[str, Search] = {"moment": moments, "frequency": tones, "place": places, "origin": origins}
"""By the role of the parameter that is looked for."""


def found_by_search(problem: LinearProblem, residual: Array, members: list[Candidate]) -> list[Candidate]:
    """The members of a candidate after its search, if it has one: what fits the residual (n, q) best.

    The search is made with the first member; the others take over what it found.
    """
    role = members[0].effect.search_role()
    if role is None:
        return members
    found = SEARCHES[role](problem, residual, members[0])
    return [
        replace(member, nonlinear=tuple((dict(one.nonlinear) | dict(member.nonlinear)).items()), tried=one.tried)
        for one in found
        for member in members
    ]


def between_neighbours(member: Candidate, misfit: Callable[[Candidate], float]) -> Candidate | None:
    """A member with its one listed number moved between its neighbours in the list to where the misfit is least.

    The number may lie between two listed ones: where a search has moved it before.
    """
    if len(member.effect.search) != 1 or member.effect.search_role():
        return None
    ((name, listed),) = member.effect.search.items()
    value = dict(member.nonlinear)[name]
    low = max((one for one in listed if one < value), default=value)
    high = min((one for one in listed if one > value), default=value)
    floor = max(low, high * 1e-3)
    best = minimize_scalar(
        lambda x: misfit(member.at({name: float(np.exp(x))})),
        bounds=(np.log(floor), np.log(high)),
        method="bounded",
        options={"xatol": 0.01, "maxiter": 12},
    )
    return member.at({name: float(np.exp(best.x))}, max(member.tried, len(listed)))
