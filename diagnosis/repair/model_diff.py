"""What a diagnosis changes in a model, as a unified diff of the two model files."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from diagnosis.result import Diagnosis
from scenarios.toml import to_toml
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.scenario import Scenario


def model_diff(found: Diagnosis) -> tuple[str, ...]:
    """Lines of the diff from the given model to the new one, without ends; none where nothing was added."""
    return lines_of_diff(found.problem.effects, found.model)


def lines_of_diff(given_effects: Sequence[Effect], model: Scenario) -> tuple[str, ...]:
    """The same from a new model and the effects that the given one had."""
    tables, order = as_tables(tuple(given_effects))
    given = model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = to_toml(given).splitlines(), to_toml(model).splitlines()
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))
