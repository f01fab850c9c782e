"""What the model's own effects add where no attitude is compared: taken off the measurement before iron is fitted."""

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
UNSEEN_BY_STRENGTH = frozenset({"attitude", "position"})
"""What an effect may need that a strength alone does not show."""
STEPS = 2
"""Times that the model's effects are found along the field that is left without them."""


def seen_by(problem: LinearProblem) -> frozenset[str]:
    """What a problem holds of the causes that effects need."""
    return problem.has - UNSEEN_BY_STRENGTH if problem.mode == "strength" else problem.has


def beside_known(pose: Pose, recording: Recording, effects: Sequence[Effect]) -> LinearProblem:
    """The problem posed of a recording less what effects add beyond iron, along the field that it finds.

    The iron is fitted anew, in place of theirs. Effects whose causes were not recorded are left out, and so are those
    that are random, or done to each value.
    """
    problem = pose(recording)
    known = [one for one in effects if set(one.needs) <= seen_by(problem) and not one.traits.converter]
    added_nT = np.zeros_like(recording.mag_nT)
    for _ in range(STEPS if any(map(_is_beyond_iron, known)) else 0):
        added_nT = beyond_iron_nT(known, problem.state)
        problem = pose(replace(recording, mag_nT=recording.mag_nT - added_nT))
    predicted_nT = problem.predicted_nT + added_nT
    return replace(problem, recording=recording, effects=tuple(effects), predicted_nT=predicted_nT)


def beyond_iron_nT(effects: Sequence[Effect], state: State) -> Array:
    """What a chain of effects adds (n, 3) to what its iron alone makes of the field."""
    iron = [one for one in effects if one.traits.absorbed]
    return apply_deterministic(effects, state)[0] - apply_deterministic(iron, state)[0]


def _is_beyond_iron(effect: Effect) -> bool:
    return not effect.traits.absorbed and not effect.stochastic
