"""Every scenario of the catalogue: loads, suits its vehicle, round-trips; sizes that its header promises."""

from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from scenarios.errors import InputError
from scenarios.load import catalogue
from scenarios.names import CATALOGUE, scenario_names
from scenarios.paths import Start
from scenarios.paths.excited import Excited
from scenarios.toml import as_dict, to_toml
from scenarios.vary import apply_vary
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.iron import HardIron, SoftIron
from sim.effects.noise import FlickerNoise
from sim.effects.offsets import SensorOffset
from sim.scenario import Scenario, SensorSpec, json_schema, load
from sim.vehicles import vehicles_for

E = TypeVar("E", bound=Effect)
NAMES = scenario_names()
PROMISED = {
    *("auv-dive", "auv-spiral", "auv-spiral-excited", "auv-comb", "quad-spiral", "quad-comb", "quad-calibration"),
    *("turntable-twelve-stops", "turntable-three-turns", "tumble", "gradiometer-turntable"),
    *("standard-full", "standard-pitch", "standard-auv"),
    *("auv-fleet", "quad-fleet", "turntable-fleet"),
}


def test_catalogue_is_complete() -> None:
    assert set(catalogue()) == set(NAMES) == PROMISED
    assert all(0 < len(summary) <= 110 for summary in catalogue().values())


@pytest.mark.parametrize("name", NAMES)
def test_scenario_loads_and_is_described(name: str) -> None:
    scenario = load(name)
    assert scenario.name == name
    assert all(scenario.vehicle.kind in vehicles_for(phase) for phase in scenario.phases)
    assert (CATALOGUE / f"{name}.toml").read_text().startswith("# ")
    assert scenario.effect_order is None or set(scenario.effect_order) == set(scenario.effects)


@pytest.mark.parametrize("name", NAMES)
def test_scenario_round_trips(name: str, tmp_path: Path) -> None:
    path = tmp_path / "again.toml"
    path.write_text(to_toml(load(name)))
    assert load(path) == load(name)


def _vector(name: str, effect: str, key: str) -> Any:
    return np.array(getattr(load(name).effects[effect][0], key))


def _first(owner: Scenario | SensorSpec, kind: type[E]) -> E:
    effect = owner.effects[kind.name][0]
    assert isinstance(effect, kind)
    return effect


def _axes(xy: float, xz: float, yz: float) -> Any:
    first = (np.cos(xz) * np.cos(xy), np.sin(xy), np.sin(xz) * np.cos(xy))
    return np.array([first, (0, np.cos(yz), np.sin(yz)), (0, 0, 1)])


def _level_field(field_enu_nT: Any) -> Any:
    heading = np.radians(np.arange(360))
    cos, sin, (east, north, up) = np.cos(heading), np.sin(heading), field_enu_nT
    return np.column_stack([cos * east + sin * north, cos * north - sin * east, np.full(360, up)])


def test_dive_has_zhangs_raw_error_along_a_turn() -> None:
    """[Zhang2018]: total-field error 96.1 to 292.4 nT, eq. 1 with the scenario's values."""
    field = np.array([-11484.12, 12637.48, 32730.72])
    x, y, z = np.sin(np.radians(_vector("auv-dive", "misalignment", "angles_deg")))
    installation = np.array([[1, -z, y], [-z, 1, -x], [y, -x, 1]])
    axes = _axes(*np.radians(_vector("auv-dive", "non_orthogonality", "angles_deg")))
    soft = installation @ axes @ np.diag(1 + _vector("auv-dive", "scale", "error"))
    h = _vector("auv-dive", "hard_iron", "offset_nT")
    np.testing.assert_array_equal(h, _vector("auv-dive", "sensor_offset", "offset_nT"))
    error = np.linalg.norm((_level_field(field) + h) @ soft.T + h, axis=1) - np.linalg.norm(field)
    np.testing.assert_allclose((error.min(), error.max()), (96.1, 292.4), atol=1.0)


def test_quadrotor_has_lis_raw_component_errors() -> None:
    """[Li2017]: 3660, 4813, 2793 nT rms before compensation."""
    field = load("quad-comb").field.enu_nT
    assert field == (-1940, 31916, -41285)
    soft, hard = _vector("quad-comb", "soft_iron", "matrix"), _vector("quad-comb", "hard_iron", "offset_nT")
    error = _level_field(field) @ soft.T + hard
    np.testing.assert_allclose(np.sqrt((error**2).mean(axis=0)), (3660, 4813, 2793), rtol=0.02)


def test_twelve_stops_have_zhous_five_values() -> None:
    name = "turntable-twelve-stops"
    x, y, z = np.radians(_vector(name, "misalignment", "angles_deg"))
    Rx = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    Ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    Rz = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    A = _axes(*np.radians(_vector(name, "non_orthogonality", "angles_deg"))) @ Rz @ Ry @ Rx
    ours = (A[0, 2], A[1, 0], A[1, 2], A[2, 0], A[2, 1])
    np.testing.assert_allclose(ours, (0.013572, 0.000115, -0.006312, -0.021201, -0.003657), atol=1e-7)
    assert A[0, 1] == pytest.approx(0, abs=1e-7)


def test_three_turns_have_longs_axes() -> None:
    axes = _axes(*np.radians(_vector("turntable-three-turns", "non_orthogonality", "angles_deg")))
    cos_b, cos_g, alpha = *np.cos(np.radians([87.6, 87])), np.radians(1.2)
    expected = [[np.sqrt(1 - cos_b**2 - cos_g**2), cos_b, cos_g], [0, np.cos(alpha), np.sin(alpha)], [0, 0, 1]]
    np.testing.assert_allclose(axes, expected, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "strength_nT"),
    [("turntable-three-turns", 48_152), ("gradiometer-turntable", 52_000), ("standard-full", 36_917.35)],
)
def test_field_strengths(name: str, strength_nT: float) -> None:
    assert np.linalg.norm(load(name).field.enu_nT) == pytest.approx(strength_nT, abs=0.02)


def _turned(vector: Any, angle: Any, axis: int) -> Any:
    """Vectors (n, 3) seen from axes that are turned by the angle about an axis."""
    out, (i, j) = np.array(vector, dtype=float), ((axis + 1) % 3, (axis + 2) % 3)
    out[:, i] = np.cos(angle) * vector[:, i] + np.sin(angle) * vector[:, j]
    out[:, j] = np.cos(angle) * vector[:, j] - np.sin(angle) * vector[:, i]
    return out


def _body_field(field: Any, yaw: Any, pitch: Any, roll: Any) -> Any:
    return _turned(_turned(_turned(np.tile(field, (len(yaw), 1)), yaw, 2), pitch, 1), roll, 0)


STANDARD = {
    "full": ((np.pi, 0.097, 0.3), (np.radians(88), 0.053, 1.1), 0.11),
    "pitch": ((np.radians(5), 2 * np.pi / 31, 0), (np.radians(45), 2 * np.pi / 47, 0), np.radians(6)),
    "auv": ((np.radians(5), 2 * np.pi / 31, 0), (np.radians(5), 2 * np.pi / 47, 0), np.radians(6)),
}


@pytest.mark.parametrize("name", STANDARD)
def test_standard_case_is_the_same_in_the_benchs_frames(name: str) -> None:
    """Stated in forward, right, down and north, east, down; m = S h + b."""
    t = np.arange(3600) / 10
    (roll, roll_rate, roll_phase), (pitch, pitch_rate, pitch_phase), yaw_rate = STANDARD[name]
    angles = yaw_rate * t, pitch * np.sin(pitch_rate * t + pitch_phase), roll * np.sin(roll_rate * t + roll_phase)
    h = _body_field([12637.48, -11484.12, -32730.72], *angles)
    S = np.array([[1.1198, 0.0120, -0.0154], [0.0120, 1.0097, -0.0090], [-0.0154, -0.0090, 0.9590]])
    expected = (h @ S.T + [1200, -800, 2000]) * [1, -1, -1]
    scenario = load(f"standard-{name}")
    reference = scenario.phases[0].reference(Start((0, 0, 0), 0), t + 10)
    ours = _body_field(scenario.field.enu_nT, *reference[:, 9:12].T)
    soft, hard = (np.array(v) for v in (_first(scenario, SoftIron).matrix, _first(scenario, HardIron).offset_nT))
    np.testing.assert_allclose(ours + ours @ np.transpose(soft) + hard, expected, atol=0.1)


def test_excited_circles_differ_from_the_level_ones_in_the_excitation_alone() -> None:
    level, excited = as_dict(load("auv-spiral")), as_dict(load("auv-spiral-excited"))
    phases = level.pop("phases")[0], excited.pop("phases")[0]
    differ = {key for key in phases[1] if phases[0][key] != phases[1][key]}
    assert differ == {"roll_amplitude_deg", "pitch_amplitude_deg"}
    assert {key for key in level if level[key] != excited[key]} == {"name", "summary"}


def test_quadrotor_refuses_commanded_tilt() -> None:
    with pytest.raises(InputError, match=r"phases\.0: the quadrotor cannot roll or pitch"):
        load("quad-spiral", ["phases.0.roll_amplitude_deg=10"])
    assert isinstance(load("quad-spiral").phases[0], Excited)


def test_vary_is_reproducible_and_in_range() -> None:
    scenario = load("gradiometer-turntable")
    one, same, other = (apply_vary(scenario, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one == same != other
    offsets = np.array([_first(sensor, SensorOffset).offset_nT for sensor in one.sensors])
    assert len(set(offsets.ravel())) == 12
    assert np.abs(offsets).max() <= 200
    assert not one.vary
    assert apply_vary(one, np.random.default_rng(3)) == one


def test_vary_draws_in_sorted_order_of_keys() -> None:
    scenario = load("tumble", ['vary."effects.flicker_noise.density_nT_sqrt_hz".normal=[30, 1]'])
    assert list(scenario.vary) != sorted(scenario.vary)
    drawn, rng = apply_vary(scenario, np.random.default_rng(7)), np.random.default_rng(7)
    np.testing.assert_allclose(_first(drawn, FlickerNoise).density_nT_sqrt_hz, rng.normal(30, 1, 3), rtol=1e-15)
    np.testing.assert_array_equal(_first(drawn, HardIron).offset_nT, rng.uniform(-4000, 4000, 3))


def test_schema_knows_the_files_keys() -> None:
    schema = json_schema()
    assert set(schema["properties"]) == set(Scenario.model_fields)
    assert schema["additionalProperties"] is False
    assert "duration_s" in schema["$defs"]["Spiral"]["properties"]
    kinds = schema["properties"]["phases"]["items"]["discriminator"]["mapping"]
    for name in NAMES:
        for phase in as_dict(load(name))["phases"]:
            keys = schema["$defs"][kinds[phase["kind"]].rsplit("/", 1)[1]]["properties"]
            assert set(phase) <= set(keys)


def test_schema_is_complete_to_the_parameters_of_each_effect() -> None:
    schema = json_schema()
    known = schema["$defs"]
    for owner in (schema, known["SensorSpec"]):
        assert owner["properties"]["effects"]["$ref"] == "#/$defs/Effects"
    assert known["Effects"]["additionalProperties"] is False
    assert list(known["Effects"]["properties"]) == list(BY_NAME)
    for name, cls in BY_NAME.items():
        one, several = known["Effects"]["properties"][name]["anyOf"]
        table = known[one["$ref"].rsplit("/", 1)[1]]
        assert several["items"] == one
        assert list(table["properties"]) == [*(p.name for p in cls.parameters()), "active_s"]
        assert table["additionalProperties"] is False
    offset = known["HardIron"]["properties"]["offset_nT"]
    assert (offset["minItems"], offset["prefixItems"][2]) == (3, {"type": "number", "minimum": -1e6, "maximum": 1e6})
