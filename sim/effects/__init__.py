"""Effects: the classes, the table of all of them, and the conversion from and to a scenario's tables."""

from __future__ import annotations

from sim.effects.registry import BY_NAME, EFFECTS, describe, find, of_sign, summary
from sim.effects.tables import EffectName, Effects, as_tables, build, check_order, in_order

__all__ = [
    "BY_NAME",
    "EFFECTS",
    "EffectName",
    "Effects",
    "as_tables",
    "build",
    "check_order",
    "describe",
    "find",
    "in_order",
    "of_sign",
    "summary",
]
