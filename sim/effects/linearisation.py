"""Linear part of an effect with a curved characteristic."""

from __future__ import annotations

import numpy as np

from sim.effects.base import PLAIN, Effect
from sim.state import State


def linearise(effect: Effect, along: State) -> Effect:
    """The plain form of a motor's effect that best follows the fuller form, a constant left free; the rest unchanged.

    The first coefficient of a bent line is the slope at zero, possibly with the opposite sign of the observed slope.
    """
    fuller = any(p.role == "linear" and p.form in effect.forms_in_use[1:] for p in effect.parameters())
    if effect.with_role("motor") is None or not fuller:
        return effect
    others = {name: getattr(effect, name) for name in effect.names() if name not in effect.linear}
    bent = effect.contribution(along, along.field_nT, np.random.default_rng(0), {})
    columns = type(effect).basis(along, along.field_nT, (PLAIN,), **others)
    A = (columns - columns.mean(axis=0)).reshape(bent.size, -1)
    slope = np.linalg.lstsq(A, bent.ravel(), rcond=None)[0]
    return type(effect).combine(slope, (PLAIN,), **others)
