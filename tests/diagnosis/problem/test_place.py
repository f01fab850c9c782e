"""What a chain makes of a further effect, by the difference of the chain with and without it."""

from __future__ import annotations

import numpy as np
import pytest

from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.iron import HardIron, SoftIron
from sim.effects.offsets import SensorOffset
from tests.diagnosis.synthetic import problem, recording

GIVEN = tuple(one(**one.example) for one in (SoftIron, HardIron, Misalignment, NonOrthogonality, Scale, SensorOffset))
ADDS = [one for one in EFFECTS if one.stage == "vehicle" and one is not HardIron]


@pytest.mark.parametrize("effect", ADDS, ids=lambda one: one.name)
@pytest.mark.parametrize("given", [GIVEN, GIVEN[::-1]], ids=["physical", "reversed"])
def test_an_effect_meets_what_stands_ahead_and_passes_what_stands_behind(
    effect: type[Effect], given: tuple[Effect, ...]
) -> None:
    """But for a constant, which is hard iron."""
    posed, made = problem(recording(600), given), effect(**effect.example)
    with_it, without = (apply_deterministic(some, posed.state)[0] for some in (insert_effects(given, [made]), given))
    own = made.apply(posed.state, posed.input_nT(effect), np.random.default_rng(0), {})
    off = own @ posed.matrix_behind(effect).T - (with_it - without)
    assert off == pytest.approx(np.tile(off[0], (600, 1)), abs=1e-6)


def test_without_a_model_all_that_differs_is_iron() -> None:
    """Which an effect of the vehicle or of the sensor stands behind, and the earth's field before."""
    posed = problem(hidden={"soft_iron": {"matrix": SoftIron.example["matrix"]}})
    assert posed.turn - np.eye(3) == pytest.approx(np.array(SoftIron.example["matrix"]), abs=1e-3)
    for one in EFFECTS:
        assert posed.matrix_behind(one) == pytest.approx(posed.turn if one.stage == "field" else np.eye(3))
