"""The straight line of an effect whose characteristic is bent."""

from __future__ import annotations

import numpy as np

from sim.effects.base import PLAIN, Effect
from sim.state import State


def linearise(effect: Effect, along: State) -> Effect:
    """An effect of motors in the plain form that follows its fuller one best but for a constant; any other as it is.

    The first coefficient of a bent line is its slope at zero, which may have another sign than all that was seen.
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
