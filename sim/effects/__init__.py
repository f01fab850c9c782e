"""Effects: one class each, one table of them all, and the way from a scenario's tables to them and back."""

from __future__ import annotations

from sim.effects.registry import BY_NAME, EFFECTS, describe, find, summary
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
    "summary",
]
