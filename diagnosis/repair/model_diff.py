"""The change of a model by a diagnosis, as a unified diff of model files."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

from diagnosis.result import Diagnosis
from scenarios.toml import to_toml
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.scenario import Scenario

DIGITS = 5
"""Significant digits of a number in the diff; the model's file has all."""
LONG_NUMBER = re.compile(r"-?\d+\.\d{4,}(?:e[+-]?\d+)?")


def model_diff(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Lines of the diff from the given model to the new one, without line ends; empty if nothing was added."""
    return lines_of_diff(diagnosis.given, diagnosis.model)


def lines_of_diff(given_effects: Sequence[Effect], model: Scenario) -> tuple[str, ...]:
    """Lines of the diff from the effects of the given model to a new model."""
    tables, order = as_tables(tuple(given_effects))
    given = model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = _compared(given), _compared(model)
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))


def _compared(model: Scenario) -> list[str]:
    """Lines of what a diagnosis compares, the field and the effects, with numbers of DIGITS significant digits."""
    head, *tables = re.split(r"^(?=\[)", to_toml(model), flags=re.MULTILINE)
    order = [line for line in head.splitlines() if line.startswith("effect_order")]
    compared = (table for table in tables if table.startswith(("[field", "[effects", "[[effects")))
    text = "\n".join([*order, "", *compared])
    return LONG_NUMBER.sub(lambda number: f"{float(number[0]):.{DIGITS}g}", text).splitlines()
