"""The change of a model by a diagnosis, as a unified diff of model files."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from diagnosis.result import Diagnosis
from scenarios.toml import to_toml
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.scenario import Scenario


def model_diff(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Lines of the diff from the given model to the new one, without line ends; empty if nothing was added."""
    return lines_of_diff(diagnosis.problem.effects, diagnosis.model)


def lines_of_diff(given_effects: Sequence[Effect], model: Scenario) -> tuple[str, ...]:
    """Lines of the diff from the effects of the given model to a new model."""
    tables, order = as_tables(tuple(given_effects))
    given = model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = to_toml(given).splitlines(), to_toml(model).splitlines()
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))
