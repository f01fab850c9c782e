"""Parameters of an effect from coefficients of its columns, with standard deviations."""

from __future__ import annotations

from typing import Any

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.base import Effect

STEP = 1e-3
"""Step of a coefficient over its standard deviation, and of a listed value over itself, for a finite difference."""
Spread = dict[str, Array]


def parameters_of(candidate: Candidate, c: Array, covariance: Array, problem: LinearProblem) -> tuple[Effect, Spread]:
    """Return the effect with coefficients (k,) of covariance (k, k), and the standard deviations of its parameters.

    ``C_p = J C J^T`` with the slopes J of the parameters. An effect without linear parameters has one column at a
    listed value v, whose size varies as v to a power p: a coefficient c gives ``v c^(1/p)``.
    """
    if not candidate.effect.linear and not candidate.effect.tangents:
        return _at_listed(candidate, float(c[0]), float(np.sqrt(covariance[0, 0])), problem)
    effect = candidate.to_effect(c)
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    slopes: dict[str, list[Array]] = {}
    for step in np.diag(np.where(std > 0, STEP * std, STEP)):
        moved = candidate.to_effect(c + step)
        for p in effect.parameters():
            if p.name not in dict(candidate.nonlinear) and not p.worded:
                change = np.asarray(getattr(moved, p.name)) - np.asarray(getattr(effect, p.name))
                slopes.setdefault(p.name, []).append(np.asarray(change / step.sum()))
    return effect, {name: _std(np.array(J), covariance) for name, J in slopes.items() if np.any(J)}


def _std(J: Array, covariance: Array) -> Array:
    """Standard deviations (...) of a parameter with slopes J (k, ...)."""
    return np.asarray(np.sqrt(np.maximum(np.einsum("i...,ij,j...->...", J, covariance, J), 0.0)))


def _at_listed(candidate: Candidate, c: float, std: float, problem: LinearProblem) -> tuple[Effect, Spread]:
    ((name, value),) = candidate.nonlinear
    p = _power(candidate, name, float(value), problem)
    bounds = next(
        (parameter.low, parameter.high) for parameter in candidate.effect.parameters() if parameter.name == name
    )
    moved = float(np.clip(value * max(c, STEP) ** (1 / p), *bounds))
    values: dict[str, Any] = {name: moved}
    return candidate.effect(**values), {name: np.asarray(abs(moved * std / (max(c, STEP) * p)))}


def _power(candidate: Candidate, name: str, value: float, problem: LinearProblem) -> float:
    """``d ln|E| / d ln v`` of the column at a listed value."""
    sizes = [
        float(np.linalg.norm(candidate.at({name: value * factor}).columns(problem))) for factor in (1.0, 1.0 + STEP)
    ]
    return float(np.log(sizes[1] / sizes[0]) / np.log1p(STEP))
