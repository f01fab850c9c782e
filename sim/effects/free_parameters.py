"""The free parameters of effects as one vector, for a refinement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.parameters import Role

STAY: tuple[Role, ...] = ("moment", "motor", "channel", "fixed")
"""Roles of parameters excluded from refinement: a sample found by a search, a whole number, a name, a convention."""
FIRST_STEP, LEAST_STEP = 0.1, 1e-6
"""Scale of a number at zero: share of the largest component of the parameter, and least scale."""


@dataclass(frozen=True)
class FreeParameters:
    """For each effect the coefficients of the linear parameters, then the components of the further free parameters.

    A parameter is free unless the role fixes it; of a fuller form only if the form is in use; a nonlinear parameter
    only if not at the value "none".
    """

    effects: tuple[Effect, ...]

    @cached_property
    def values(self) -> Array:
        """The free numbers (k,)."""
        return np.concatenate([np.zeros(0), *(part for effect in self.effects for part in _parts(effect))])

    @cached_property
    def scale(self) -> Array:
        """Size (k,) of a relevant change of each number."""
        parts = [part for effect in self.effects for part in _parts(effect) if len(part)]
        sizes = [np.full(len(part), max(float(np.abs(part).max()) * FIRST_STEP, LEAST_STEP)) for part in parts]
        return np.asarray(np.maximum(np.abs(self.values), np.concatenate([np.zeros(0), *sizes])))

    @cached_property
    def _cuts(self) -> NDArray[np.intp]:
        """Index at which the numbers of each effect but the first begin."""
        return np.cumsum([sum(map(len, _parts(effect))) for effect in self.effects])[:-1]

    def at(self, x: Array) -> tuple[Effect, ...]:
        """The effects with new numbers (k,), clipped to the bounds.

        Raises InputError where the numbers of an effect contradict each other.
        """
        return tuple(_with(effect, part) for effect, part in zip(self.effects, np.split(x, self._cuts), strict=True))

    def spread(self, std: Array) -> tuple[dict[str, Array], ...]:
        """Standard deviations (k,) of the numbers by parameter and component, for each effect."""
        return tuple(
            _spread(effect, part) for effect, part in zip(self.effects, np.split(std, self._cuts), strict=True)
        )


def _others(effect: Effect) -> tuple[str, ...]:
    """Names of the free nonlinear parameters."""
    return tuple(
        p.name
        for p in effect.parameters()
        if p.name not in effect.linear
        and p.role not in STAY
        and p.form in effect.forms_in_use
        and (p.role == "phase" or bool(np.any(np.asarray(getattr(effect, p.name)) != 0)))
    )


def _parts(effect: Effect) -> Sequence[Array]:
    return effect.coefficients(effect.forms_in_use), *(np.ravel(getattr(effect, name)) for name in _others(effect))


def _with(effect: Effect, x: Array) -> Effect:
    """The effect with free numbers (k,) clipped to the bounds."""
    forms = effect.forms_in_use
    k = len(effect.linear_units(forms))
    bounds = {p.name: (p.low, p.high) for p in effect.parameters()}
    values: dict[str, Any] = {name: getattr(effect, name) for name in effect.names() if name not in effect.linear}
    at = k
    for name in _others(effect):
        now = np.asarray(values[name])
        values[name] = np.clip(x[at : at + now.size], *bounds[name]).reshape(now.shape)
        at += now.size
    if not k:
        return replace(effect, **values)
    low, high = np.array([bounds[name] for name, _ in effect.linear_units(forms)]).T
    return effect.combine(np.clip(x[:k], low, high), forms, **values)


def _spread(effect: Effect, std: Array) -> dict[str, Array]:
    spread: dict[str, Array] = {}
    units = effect.linear_units(effect.forms_in_use)
    for (name, unit), one in zip(units, std[: len(units)], strict=True):
        part = np.where(unit == 0, 0.0, one) * np.where(unit == 0, 1.0, np.abs(unit))
        spread[name] = np.hypot(spread.get(name, 0.0), part)
    at = len(units)
    for name in _others(effect):
        shape = np.shape(getattr(effect, name))
        spread[name] = std[at : at + int(np.prod(shape))].reshape(shape)
        at += int(np.prod(shape))
    return spread
