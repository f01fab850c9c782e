"""From a scenario's tables to effects and back, and what a user reads when a table is wrong."""

from __future__ import annotations

import json

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.effects import BY_NAME, Effects, as_tables, build, describe, in_order, summary
from sim.effects.geometry import Scale
from sim.effects.iron import HardIron
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import OffsetJump, SensorOffset


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"hard_irn": {}}, "a.toml: effects.hard_irn: no effect of this name (did you mean hard_iron"),
        ({"hard_iron": {"ofset_nT": 3}}, "a.toml: effects.hard_iron: no parameter 'ofset_nT' (it has offset_nT)"),
        ({"hard_iron": {"offset_nT": 3}}, "a.toml: effects.hard_iron.offset_nT: expected three numbers, found 3"),
        ({"hard_iron": {"offset_nT": [1, 2]}}, "expected three numbers, found [1, 2]"),
        ({"hard_iron": {"offset_nT": [1, 2, [3]]}}, "expected three numbers, found [1, 2, [3]]"),
        ({"hard_iron": {"offset_nT": "big"}}, "expected three numbers, found 'big'"),
        ({"hard_iron": {"offset_nT": [1, 2, True]}}, "expected three numbers, found [1, 2, True]"),
        ({"hard_iron": {"offset_nT": [1, 2, 1e9]}}, "effects.hard_iron.offset_nT: 1e+09 is outside -1e+06 to 1e+06 nT"),
        (
            {"hard_iron": 3},
            "a.toml: effects.hard_iron: an effect is a table of parameters, or an array of tables",
        ),
        ({"hard_iron": [{}, {"offset_nT": 1}]}, "a.toml: effects.hard_iron.1.offset_nT: expected three numbers"),
        ({"white_noise": {"std_nT": [1, 2]}}, "expected a number or three numbers, found [1, 2]"),
        ({"white_noise": {"std_nT": -1}}, "-1 is outside 0 to 100000 nT"),
        ({"white_noise": {"std_nT": float("nan")}}, "expected finite numbers, found nan"),
        ({"soft_iron": {"matrix": [1, 2, 3]}}, "expected three rows of three numbers"),
        ({"motor_current": {"motor": 1.5}}, "expected a whole number, found 1.5"),
        ({"hysteresis": {"threshold_nT": []}}, "expected a number or a list of numbers, found []"),
        ({"misalignment": {"form": "zhang"}}, "expected one of rotation, zhang2018, found 'zhang'"),
        ({"field_gradient": {"gradient_nT_m": np.eye(3).tolist()}}, "effects.field_gradient: gradient_nT_m must have"),
    ],
)
def test_a_wrong_table_is_told_in_one_line(tables, message):
    with pytest.raises(InputError) as caught:
        build(tables, None, "a.toml")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_effects_come_in_physical_order_whatever_the_order_of_the_tables():
    effects = build({"white_noise": {"std_nT": 1}, "scale": {}, "hard_iron": [{}, {"offset_nT": [1, 2, 3]}]}, None, "")
    assert [effect.name for effect in effects] == ["hard_iron", "hard_iron", "scale", "white_noise"]
    assert effects[1] == HardIron((1.0, 2.0, 3.0))
    assert effects[3] == WhiteNoise((1.0, 1.0, 1.0))


def test_a_scenario_may_give_another_order():
    tables = {"hard_iron": {}, "scale": {}}
    assert [e.name for e in build(tables, ("spikes", "scale", "hard_iron"), "")] == ["scale", "hard_iron"]


@pytest.mark.parametrize(
    ("order", "message"),
    [
        (("scale",), "effect_order: does not name hard_iron"),
        (("scale", "hard_iron", "scale"), "scale is named twice"),
        (("scale", "hardiron"), "no effect 'hardiron'"),
    ],
)
def test_a_wrong_order_is_refused(order, message):
    with pytest.raises(InputError, match=message):
        build({"hard_iron": {}, "scale": {}}, order, "a.toml")


def test_tables_of_effects_give_the_same_effects_in_the_same_order():
    effects = (Scale(0.1), HardIron((1, 2, 3)), OffsetJump(3.0, (1, 1, 1)), OffsetJump(5.0, (2, 2, 2)))
    tables, order = as_tables(effects)
    assert build(json.loads(json.dumps(tables)), order, "") == effects


def test_effects_that_no_table_can_order_are_refused():
    with pytest.raises(InputError, match="follow each other"):
        as_tables((HardIron(), Scale(), HardIron()))


def test_a_sensor_adds_its_own_effects():
    shared = Effects({"hard_iron": {"offset_nT": [1, 0, 0]}})
    own = Effects({"hard_iron": [{"offset_nT": [0, 1, 0]}], "sensor_offset": {"offset_nT": [0, 0, 1]}})
    assert in_order([shared, own], None) == (HardIron((1, 0, 0)), HardIron((0, 1, 0)), SensorOffset((0, 0, 1)))
    assert shared["hard_iron"] == (HardIron((1, 0, 0)),)


def test_tables_are_kept_as_they_are_written():
    written = {"white_noise": {"std_nT": 5}, "hard_iron": {}}
    assert list(Effects(written).written.items()) == list(written.items())
    assert Effects(written) != Effects({"white_noise": {"std_nT": [5, 5, 5]}, "hard_iron": {}})


def test_numpy_values_are_taken():
    assert HardIron(np.array([1, 2, 3])) == HardIron((1.0, 2.0, 3.0))
    assert WhiteNoise(np.float64(2.0)) == WhiteNoise((2.0, 2.0, 2.0))


def test_every_effect_is_described():
    for name, cls in BY_NAME.items():
        assert summary(name)
        assert all(p.name in describe(name) for p in cls.parameters())
