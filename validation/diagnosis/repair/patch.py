"""The new model: named effects joined to the given ones, refined through the simulator's own chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from scenarios.errors import InputError
from sim.chain import apply_deterministic
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.evidence.problem import Problem

UNMOVED = ("motor", "time_s", "reference_degC", "reference_nT", "origin_enu_m", "extent_enu_m")
"""Parameters that are not refined: whole numbers, conventions, and a moment (a sample, found by search)."""
ROUNDS = 12
OPEN = 1e-8
"""Eigenvalue of the correlation of parameters below which their combination is not determined."""


@dataclass(frozen=True)
class Refined:
    """Effects after refinement and, for each, name of a parameter -> standard deviation of its components."""

    effects: tuple[Effect, ...]
    spread: tuple[dict[str, Array], ...]


def joined(given: Sequence[Effect], new: Sequence[Effect]) -> tuple[Effect, ...]:
    """The given effects with new ones at their physical place, the given order kept."""
    rank = {name: i for i, name in enumerate(BY_NAME)}
    out = list(given)
    for effect in new:
        same = [i for i, other in enumerate(out) if other.name == effect.name]
        later = [i for i, other in enumerate(out) if rank[other.name] > rank[effect.name]]
        out.insert(same[-1] + 1 if same else (later[0] if later else len(out)), effect)
    return tuple(out)


def refined(
    problem: Problem, new: Sequence[Effect], use: NDArray[np.bool_], inflation: float = 1.0, *, refit: bool = True
) -> Refined:
    """Least squares of the new effects' parameters on the samples `use` (n,).

    refit : hard and soft iron are refitted at every step; otherwise they are the model's.

    The prediction is the simulator's chain along the measured motion; standard deviations from the Jacobian there,
    times the root of `inflation` for what is coloured.
    """
    free = [_free(effect) for effect in new]
    start = np.concatenate([np.zeros(0), *(_values(e, names) for e, names in zip(new, free, strict=True))])
    if problem.mode != "vector" or not len(start):
        return Refined(tuple(new), tuple({} for _ in new))
    scale = np.maximum(np.abs(start), _steps(new, free))

    def residual(x: Array) -> Array:
        try:
            predicted = predict(problem, _with_values(new, free, start + x * scale))
        except InputError:  # each number is within its bounds, but not all together
            return np.full(problem.target[use].size, 1e3)
        left = unexplained(problem, predicted, use) if refit else _plain(problem, predicted)
        return np.asarray(left[use].ravel())

    found = least_squares(residual, np.zeros(len(start)), diff_step=1e-4, max_nfev=ROUNDS, xtol=1e-5, ftol=1e-6)
    gram = found.jac.T @ found.jac
    std = np.sqrt(_variances(gram) * inflation) * scale
    made = _with_values(new, free, start + found.x * scale)
    return Refined(made, tuple(_split(made, free, std)))


def _variances(gram: Array) -> Array:
    """Diagonal (k,) of the inverse of a Gram matrix (k, k); infinite where the data leave a direction open."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(size, size))
    open_ = values < OPEN
    variances = (vectors[:, ~open_] ** 2 / values[~open_]).sum(axis=1) / size**2
    return np.where((vectors[:, open_] ** 2).sum(axis=1) > 1e-3, np.inf, variances)


def predict(problem: Problem, new: Sequence[Effect]) -> Array:
    """What the simulator's chain with the new effects gives along the measured motion (n, 3)."""
    effects = [e for e in joined(problem.effects, new) if e.name not in ("quantisation", "saturation")]
    return apply_deterministic(effects, problem.state)[0]


def unexplained(problem: Problem, predicted_nT: Array, train: NDArray[np.bool_]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, hard and soft iron refitted on the samples `train`."""
    base = np.column_stack([predicted_nT / 5e4, np.ones(len(predicted_nT))])
    weight = train * problem.usable
    weighted = base * weight[:, None]
    beta = np.linalg.lstsq(weighted.T @ base, weighted.T @ problem.recording.mag_nT, rcond=1e-13)[0]
    return np.asarray((problem.recording.mag_nT - base @ beta) / problem.sigma_nT * problem.usable[:, None])


def _plain(problem: Problem, predicted_nT: Array) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, the base as the model has it."""
    left = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(left * problem.usable[:, None])


def _free(effect: Effect) -> tuple[str, ...]:
    return tuple(
        p.name for p in effect.parameters()
        if not p.options and not p.integer and p.name not in UNMOVED and _moves(effect, p.name)
    )  # fmt: skip


def _moves(effect: Effect, name: str) -> bool:
    """Whether a parameter is in use: a linear one always, another where it is not at "none"."""
    return name in effect.linear or bool(np.any(np.asarray(getattr(effect, name)) != 0)) or name == "phase_deg"


def _values(effect: Effect, names: tuple[str, ...]) -> Array:
    """Free numbers: coefficients of the linear parameters, then the components of the others."""
    rest = [np.ravel(getattr(effect, name)) for name in names if name not in effect.linear]
    return np.concatenate([effect.coefficients(), *rest])


def _steps(new: Sequence[Effect], free: Sequence[tuple[str, ...]]) -> Array:
    sizes = []
    for effect, names in zip(new, free, strict=True):
        c = effect.coefficients()
        rest = [np.ravel(getattr(effect, name)) for name in names if name not in effect.linear]
        sizes += [np.full(len(part), max(float(np.abs(part).max()) * 0.1, 1e-6)) for part in (c, *rest) if len(part)]
    return np.concatenate([np.zeros(0), *sizes])


def _with_values(new: Sequence[Effect], free: Sequence[tuple[str, ...]], x: Array) -> tuple[Effect, ...]:
    """The effects with new free numbers, each brought into its bounds."""
    out, at = [], 0
    for effect, names in zip(new, free, strict=True):
        k = len(effect.linear_units())
        bounds = {p.name: (p.low, p.high) for p in effect.parameters()}
        others: dict[str, Any] = {
            p.name: getattr(effect, p.name) for p in effect.parameters() if p.name not in effect.linear
        }
        limits = np.array([bounds[name] for name, _ in effect.linear_units()]).reshape(k, 2).T
        coefficients, at = np.clip(x[at : at + k], *limits), at + k
        for name in (n for n in names if n not in effect.linear):
            shape = np.shape(getattr(effect, name))
            size = int(np.prod(shape))
            others[name] = np.clip(x[at : at + size], *bounds[name]).reshape(shape)
            at += size
        out.append(type(effect).combine(coefficients, **others) if k else replace(effect, **others))
    return tuple(out)


def _split(new: Sequence[Effect], free: Sequence[tuple[str, ...]], std: Array) -> list[dict[str, Array]]:
    out, at = [], 0
    for effect, names in zip(new, free, strict=True):
        spread: dict[str, Array] = {}
        for name, unit in effect.linear_units():
            part = np.where(unit == 0, 0.0, std[at]) * np.where(unit == 0, 1.0, np.abs(unit))
            spread[name] = np.hypot(spread.get(name, 0.0), part)
            at += 1
        for name in (n for n in names if n not in effect.linear):
            size = int(np.prod(np.shape(getattr(effect, name))))
            spread[name] = std[at : at + size].reshape(np.shape(getattr(effect, name)))
            at += size
        out.append(spread)
    return out
