"""The simulator's own chain along the measured motion, with and without new effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sim.chain import apply_deterministic
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.problem.linear import LinearProblem

SCALE_NT = 5e4
"""Brings the predicted field to the size of the constant beside it."""


def joined(given: Sequence[Effect], new: Sequence[Effect]) -> tuple[Effect, ...]:
    """The given effects with new ones at their physical place, the given order kept."""
    rank = {name: i for i, name in enumerate(BY_NAME)}
    out = list(given)
    for effect in new:
        same = [i for i, other in enumerate(out) if other.name == effect.name]
        later = [i for i, other in enumerate(out) if rank[other.name] > rank[effect.name]]
        out.insert(same[-1] + 1 if same else (later[0] if later else len(out)), effect)
    return tuple(out)


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """What the simulator's chain with the new effects gives along the measured motion (n, 3).

    What the converter does to each value is left out: rounding and clipping have no slope.
    """
    smooth = [effect for effect in joined(problem.effects, new) if not effect.clues.converter]
    return apply_deterministic(smooth, problem.state)[0]


def left_with_iron_refitted(problem: LinearProblem, predicted_nT: Array, train: NDArray[np.bool_]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, hard and soft iron refitted on the samples `train`.

    At rest a constant alone: a matrix would take up whatever the new effects predict.
    """
    measured_nT = problem.recording.mag_nT
    if problem.still:
        used = train & (problem.usable > 0)
        return _left(problem, predicted_nT + (measured_nT - predicted_nT)[used].mean(axis=0))
    base = np.column_stack([predicted_nT / SCALE_NT, np.ones(len(predicted_nT))])
    weighted = base * (train * problem.usable)[:, None]
    beta = np.linalg.lstsq(weighted.T @ base, weighted.T @ measured_nT, rcond=1e-13)[0]
    return _left(problem, base @ beta)


def left_as_it_stands(problem: LinearProblem, predicted_nT: Array) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, the iron as the model has it."""
    return _left(problem, predicted_nT)


def _left(problem: LinearProblem, predicted_nT: Array) -> Array:
    left = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(left * problem.usable[:, None])
