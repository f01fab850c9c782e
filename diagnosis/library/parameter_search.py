"""Search for nonlinear parameters without a short list of values, and refinement of listed values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from diagnosis.library.candidates import Candidate
from diagnosis.library.dipole_position import find_places
from diagnosis.library.gradient_origin import find_origins
from diagnosis.library.step_times import find_moments
from diagnosis.library.tone_frequency import find_tones
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array

Search = Callable[[LinearProblem, Array, Candidate], list[Candidate]]
"""(problem, residual (n, q) of base and accepted effects, candidate) -> candidates with values."""
SEARCHES: dict[str, Search] = {
    "moment": find_moments,
    "frequency": find_tones,
    "place": find_places,
    "origin": find_origins,
}
"""Search by the role of the parameter."""


def search_parameters(problem: LinearProblem, residual: Array, settings: list[Candidate]) -> list[Candidate]:
    """The settings of a candidate after the search of its class, if any, for the best fit to the residual (n, q).

    The first setting is searched; the remaining settings adopt the result.
    """
    role = settings[0].effect.search_role()
    if role is None:
        return settings
    found = SEARCHES[role](problem, residual, settings[0])
    return [
        replace(
            candidate, nonlinear=tuple((dict(result.nonlinear) | dict(candidate.nonlinear)).items()), tried=result.tried
        )
        for result in found
        for candidate in settings
    ]


def refine_between_neighbours(candidate: Candidate, misfit: Callable[[Candidate], float]) -> Candidate | None:
    """The candidate with its single listed number at the least misfit between the neighbours in the list.

    An earlier search may have moved the number between two listed values.
    """
    if len(candidate.effect.search) != 1 or candidate.effect.search_role():
        return None
    ((name, listed),) = candidate.effect.search.items()
    best = between_neighbours(listed, dict(candidate.nonlinear)[name], lambda x: misfit(candidate.at({name: x})))
    return candidate.at({name: best}, max(candidate.tried, len(listed)))


def between_neighbours(
    listed: Sequence[float], value: float, misfit: Callable[[float], float], within: float = 0.01
) -> float:
    """The number of least misfit between the neighbours of a value in a list, to a share `within` of the number."""
    low = max((one for one in listed if one < value), default=value)
    high = min((one for one in listed if one > value), default=value)
    if low == high:
        return value
    bounds = np.log(max(low, high * 1e-3)), np.log(high)
    options = {"xatol": within, "maxiter": 12}
    found = minimize_scalar(lambda x: misfit(float(np.exp(x))), bounds=bounds, method="bounded", options=options)
    return float(np.exp(found.x))
