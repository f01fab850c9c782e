"""The table of columns: what DESIGN promises, and nothing twice."""

from __future__ import annotations

import pyarrow as pa
import pytest

from recordings import columns, schema
from recordings.columns import GROUPS, group_of, is_truth, labelled_effects


def test_names_of_a_run_with_one_magnetometer() -> None:
    names = [c.name for c in columns(motors=(1, 2), effects=("soft_iron", "hard_iron"))]
    assert names[:4] == ["time_s", "mag_x_nT", "mag_y_nT", "mag_z_nT"]
    assert {"gyro_z_rad_s", "accel_x_m_s2", "att_qw", "pos_up_m", "temperature_degC", "phase"} < set(names)
    assert {"current_1_A", "current_2_A"} < set(names)
    assert {"true_field_y_nT", "true_qz", "true_pos_north_m", "effect_soft_iron_x_nT"} < set(names)
    assert "current_3_A" not in names
    assert labelled_effects(names) == ("soft_iron", "hard_iron")


def test_names_of_an_array() -> None:
    names = [c.name for c in columns(sensors=4, effects=("scale",))]
    assert {"mag1_x_nT", "mag4_z_nT", "effect1_scale_x_nT", "effect4_scale_z_nT"} < set(names)
    assert not {"mag_x_nT", "mag5_x_nT", "effect_scale_x_nT"} & set(names)
    assert labelled_effects(names) == ("scale",)


@pytest.mark.parametrize("sensors", [1, 2, 9])
def test_table_is_unique_and_agrees_with_the_grouping_by_name(sensors: int) -> None:
    table = columns(sensors=sensors, motors=range(1, 13), effects=("hard_iron", "local_dipole"))
    assert len({c.name for c in table}) == len({c.meaning for c in table}) == len(table)
    assert all(c.group == group_of(c.name) in GROUPS for c in table)
    assert all(is_truth(c.name) == (c.group in ("truth", "effect")) for c in table)


def test_unit_in_the_name_is_the_unit_in_the_table() -> None:
    suffixes = {"nT": "nT", "rad/s": "rad_s", "m/s^2": "m_s2", "m": "m", "degC": "degC", "A": "A", "s": "s"}
    for column in columns(sensors=2, motors=(1, 2, 3), effects=("eddy_current",)):
        if column.unit in suffixes:
            assert column.name.endswith("_" + suffixes[column.unit])


def test_schema_has_unit_and_meaning_in_every_field() -> None:
    table = columns(motors=(1,), effects=("hard_iron",))
    for column, field in zip(table, schema(table), strict=True):
        assert field.metadata == {b"unit": column.unit.encode(), b"meaning": column.meaning.encode()}
        assert field.type == (pa.dictionary(pa.int32(), pa.string()) if column.name == "phase" else pa.float64())


@pytest.mark.parametrize("name", ["effective_power_W", "wheel_0_rad_s", "truename", "mag_heading", "mag_x_uT"])
def test_names_that_only_resemble_are_channels(name: str) -> None:
    assert group_of(name) == "channel"
