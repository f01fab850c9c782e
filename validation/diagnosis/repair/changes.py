"""What a diagnosis changes in a model, as a unified diff of the two model files."""

from __future__ import annotations

import difflib

from scenarios.toml import to_toml
from sim.effects import Effects, as_tables
from validation.diagnosis.result import Diagnosis


def model_diff(found: Diagnosis) -> tuple[str, ...]:
    """Lines of the diff from the given model to the new one, without ends; none where nothing was added."""
    tables, order = as_tables(found.problem.effects)
    given = found.model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = to_toml(given).splitlines(), to_toml(found.model).splitlines()
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))
