"""What may be missing: every effect that the recording has the channels for, as columns of the linear problem."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.errors import InputError
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.state import Array, State
from validation.diagnosis.evidence.problem import Problem

ABSORBED = ("soft_iron", "hard_iron", "misalignment", "non_orthogonality", "scale", "sensor_offset")
"""What the base takes up; a change of these is read from the base itself."""
PHASE = "phase_deg"
LEAST_PATH_M = 2.0
"""Shortest path on which a field may differ from place to place; a fixed sensor's navigation wanders by about one."""


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

    @property
    def settings(self) -> tuple[dict[str, Any], ...]:
        """The values of the nonlinear parameters behind each group of columns: one, or two phases a quarter apart."""
        given = dict(self.nonlinear)
        if self.effect.tangents:
            return tuple({**given, name: value} for name, values in self.effect.tangents.items() for value in values)
        if self.phased:
            return ({**given, PHASE: 0.0}, {**given, PHASE: 90.0})
        return (given,)

    @property
    def phased(self) -> bool:
        """Whether the effect has a phase: a sine and a cosine then span it."""
        return any(p.name == PHASE for p in self.effect.parameters())

    def contribution_nT(self, problem: Problem) -> Array:
        """Columns (n, 3, k) in nT at the effect's place in the chain."""
        state, signal = problem.state, self._signal(problem)
        if self.effect.linear:
            return np.concatenate([self.effect.basis(state, signal, **one) for one in self.settings], axis=2)
        rng = np.random.default_rng(0)
        return np.stack([self.effect(**one).apply(state, signal, rng, {}) for one in self.settings], axis=2)

    def made(self, c: Array) -> Effect:
        """The effect with fitted coefficients (k,) of its columns, brought into its bounds."""
        given = dict(self.nonlinear)
        if self.effect.tangents:
            ((name, values),) = self.effect.tangents.items()
            return self.effect(**given, **{name: tuple(c @ np.array(values))})
        if not self.effect.linear:
            return self.effect(**given)
        if self.phased:
            u, s, v = np.linalg.svd(c.reshape(2, -1).T, full_matrices=False)
            phase = float(np.degrees(np.arctan2(v[0, 1], v[0, 0])))
            try:
                return self.effect.combine(u[:, 0] * s[0], **given, **{PHASE: phase})
            except InputError:  # a short stretch of a long wave: amplitude and phase are one
                c = c[: len(c) // 2]
        return self.effect.combine(self._bounded(c), **given)

    def _bounded(self, c: Array) -> Array:
        """Coefficients (k,) within the bounds of their parameters."""
        bounds = {p.name: (p.low, p.high) for p in self.effect.parameters()}
        return np.array([np.clip(v, *bounds[name]) for v, (name, _) in zip(c, self.effect.linear_units(), strict=True)])

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
        and not ("position" in effect.needs and _stands(problem))
    }


def _stands(problem: Problem) -> bool:
    """Whether the path is too short for a field that differs from place to place."""
    return bool(np.ptp(problem.state.pos_enu_m, axis=0).max() < LEAST_PATH_M)


def _settings(effect: type[Effect], state: State) -> Iterator[dict[str, Any]]:
    grid: dict[str, tuple[Any, ...]] = dict(effect.search)
    if any(p.name == "motor" for p in effect.parameters()):
        motors = state.current_A.shape[1]
        grid["motor"] = tuple(range(motors + 1)) if motors > 1 else (0,)
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))
