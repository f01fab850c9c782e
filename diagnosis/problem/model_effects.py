"""Subtraction of the model's own effects from the measurement before iron is fitted, where no attitude is compared."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.state import State

Pose = Callable[[Recording], LinearProblem]
STEPS = 2
"""Number of iterations between the field and the model's effects along the field."""


def pose_without_model_effects(pose: Pose, recording: Recording, effects: Sequence[Effect]) -> LinearProblem:
    """The problem of a recording less the model's effects other than iron, evaluated along the estimated field.

    Iron is fitted in place of the model's. Effects without recorded inputs, random effects and effects of the converter
    are left out.
    """
    problem = pose(recording)
    known = [effect for effect in effects if not (problem.missing_inputs(effect) or effect.traits.converter)]
    added_nT = np.zeros_like(recording.mag_nT)
    for _ in range(STEPS if any(map(_is_beyond_iron, known)) else 0):
        added_nT = beyond_iron_nT(known, problem.state)
        problem = pose(replace(recording, mag_nT=recording.mag_nT - added_nT))
    predicted_nT = problem.predicted_nT + added_nT
    return replace(problem, recording=recording, effects=tuple(effects), predicted_nT=predicted_nT)


def beyond_iron_nT(effects: Sequence[Effect], state: State) -> Array:
    """Contribution (n, 3) of a chain of effects less the contribution of its iron alone."""
    iron = [effect for effect in effects if effect.traits.absorbed]
    return apply_deterministic(effects, state)[0] - apply_deterministic(iron, state)[0]


def _is_beyond_iron(effect: Effect) -> bool:
    return not effect.traits.absorbed and not effect.stochastic
