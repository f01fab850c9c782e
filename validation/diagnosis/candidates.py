"""What may be missing: every effect that the recording has the channels for, as columns of the linear problem."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.state import Array, State
from validation.diagnosis.problem import Problem

ABSORBED = ("soft_iron", "hard_iron", "misalignment", "non_orthogonality", "scale", "sensor_offset")
"""What the base takes up; a change of these is read from the base itself."""


@dataclass(frozen=True)
class Candidate:
    """An effect with values of its nonlinear parameters; its columns are linear in what is then left to fit.

    `tried`: how many settings a search compared to find this one, for an honest price of the search.
    """

    effect: type[Effect]
    nonlinear: tuple[tuple[str, Any], ...] = ()
    tried: int = 1

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    def contribution_nT(self, problem: Problem) -> Array:
        """Columns (n, 3, k) in nT at the effect's place in the chain."""
        state, signal = problem.state, self._signal(problem)
        given = dict(self.nonlinear)
        if self.effect.linear:
            return self.effect.basis(state, signal, **given)
        rng = np.random.default_rng(0)
        settings = [given, *()] if not self.effect.tangents else list(_tangents(self.effect, given))
        parts = [self.effect(**setting).apply(state, signal, rng, {}) for setting in settings]
        return np.stack(parts, axis=2)

    def columns(self, problem: Problem) -> Array:
        """Columns E (n, q, k) of the problem."""
        return problem.whitened(self.contribution_nT(problem), self.effect.stage)

    def _signal(self, problem: Problem) -> Array:
        """The signal that the effect meets: the field, or for the sensor and its electronics what the base predicts."""
        return problem.state.field_nT if self.effect.stage in ("field", "vehicle") else problem.clean_nT


def proposed(problem: Problem, without: frozenset[str] = frozenset()) -> dict[str, list[Candidate]]:
    """Every effect that the recording has the channels for, at the values that its class says to try."""
    return {
        effect.name: [Candidate(effect, tuple(values.items()), 1) for values in _settings(effect, problem.state)]
        for effect in EFFECTS
        if effect.name not in without
        and effect.name not in ABSORBED
        and not effect.stochastic
        and (effect.linear or effect.search or effect.tangents)
        and set(effect.needs) <= problem.has
        and not (problem.mode == "strength" and {"attitude", "position"} & set(effect.needs))
    }


def _settings(effect: type[Effect], state: State) -> Iterator[dict[str, Any]]:
    grid: dict[str, tuple[Any, ...]] = dict(effect.search)
    if any(p.name == "motor" for p in effect.parameters()):
        motors = state.current_A.shape[1]
        grid["motor"] = tuple(range(motors + 1)) if motors > 1 else (0,)
    for p in effect.parameters():
        if p.name == "reference_degC":
            grid[p.name] = (round(float(state.temperature_degC.mean()), 3),)
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def _tangents(effect: type[Effect], given: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for name, values in effect.tangents.items():
        yield from ({**given, name: value} for value in values)
