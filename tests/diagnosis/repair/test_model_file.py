"""The diff of models: what a diagnosis compares, in numbers that can be read."""

from __future__ import annotations

from diagnosis.repair.model_file import lines_of_diff
from sim.effects import Effects, as_tables
from sim.effects.iron import HardIron
from sim.scenario import load


def test_the_diff_has_field_and_effects_alone_and_short_numbers() -> None:
    tables, order = as_tables((HardIron(offset_nT=(5200.019526273762, -3097.3137692795945, 7404.954905968272)),))
    model = load("quad-comb").model_copy(update={"effects": Effects(tables), "effect_order": order})
    lines = lines_of_diff((), model)
    assert "+offset_nT = [5200, -3097.3, 7405]" in lines
    assert not any("vehicle" in line or "sampling" in line for line in lines)
    assert all(line[0] in "+-@ " for line in lines)


def test_equal_models_have_no_diff() -> None:
    tables, order = as_tables((HardIron(offset_nT=(10.0, 20.0, 30.0)),))
    model = load("quad-comb").model_copy(update={"effects": Effects(tables), "effect_order": order})
    assert lines_of_diff((HardIron(offset_nT=(10.0, 20.0, 30.0)),), model) == ()
