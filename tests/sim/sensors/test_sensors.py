"""Every sensor that a scenario can name: its data sheet's figures reach the recording, and nothing else does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import signal, stats
from scipy.optimize import minimize_scalar

from scenarios.errors import InputError
from sim.effects import BY_NAME, build
from sim.effects.noise import WhiteNoise
from sim.effects.nonlinearity import Nonlinearity
from sim.effects.offsets import SensorOffset
from sim.scenario import Scenario, equipped, json_schema, load
from sim.sensors import SENSORS
from sim.sensors.figures import hysteresis, linearity
from sim.simulation import PreparedRun, blocks, plan
from sim.state import State

RATE_HZ = 5.0
"""That the slowest sensor allows."""
VECTORS = [name for name, sensor in SENSORS.items() if not sensor.scalar]
SCALARS = [name for name, sensor in SENSORS.items() if sensor.scalar]
REST_NT = {
    "mag_03": (0.006 * 2.5**0.5,) * 3,
    "flc3_70": (0.5, 0.5, 0.5),
    "rm3100": (15.0, 15.0, 15.0),
    "bmm350": (190.0, 190.0, 450.0),
    "lis3mdl": (320.0, 320.0, 410.0),
    "hmc5883l": (200.0, 200.0, 200.0),
}
"""Standard deviation of a sample at rest as the data sheets say, at RATE_HZ where they give a density."""


def named(kind: str, *overrides: str) -> Scenario:
    """A turntable that stands still for ten minutes, with a sensor of a kind and no other effect."""
    sensors = '[{position_m=[0,0,0]}, {kind="%s"}]' if kind in SCALARS else '[{kind="%s"}]'
    rest = ("phases.0.step_deg=1e-9", "phases.0.stops=2", "phases.0.dwell_s=300", f"sampling.rate_hz={RATE_HZ}")
    return load("turntable-twelve-stops", ["effects=", *rest, "sensors=" + sensors % kind, *overrides])


def offset_nT(made: PreparedRun, sensor: int = 0) -> Any:
    (offset,) = (one for one in made.effects[sensor] if isinstance(one, SensorOffset))
    return offset.offset_nT


def recorded(scenario: Scenario, run: int = 0) -> dict[str, Any]:
    pieces = list(blocks(plan(scenario, run)))
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


@pytest.mark.parametrize("kind", SENSORS)
def test_every_sheet_says_what_it_is(kind: str) -> None:
    sensor = SENSORS[kind]
    assert sensor.name == kind
    assert sensor.document
    assert sensor.left_out
    assert len(sensor.summary) <= 110
    quantities = [figure.quantity for figure in sensor.figures]
    assert len(set(quantities)) == len(quantities)
    effects = build(sensor.tables(RATE_HZ))
    assert {effect.stage for effect in effects} <= {"sensor", "electronics"}
    for figure in sensor.figures:
        assert figure.words
        assert set(figure.spread) <= set(figure.at(RATE_HZ))


@pytest.mark.parametrize("kind", VECTORS)
def test_its_effects_and_no_others_are_in_the_recording(kind: str) -> None:
    scenario = named(kind)
    made = plan(scenario)
    assert set(made.effects_named) == set(SENSORS[kind].tables(RATE_HZ))
    columns = recorded(scenario)
    drawn = {effect for effect, _ in SENSORS[kind].spread()}
    assert all(np.any(columns[f"effect_{name}_x_nT"]) for name in drawn)


@pytest.mark.parametrize("kind", REST_NT)
def test_noise_at_rest_is_that_of_the_sheet(kind: str) -> None:
    """With the rounding's variance, a twelfth of the squared step; five standard errors of a standard deviation."""
    columns = recorded(named(kind))
    mag = np.column_stack([columns[f"mag_{axis}_nT"] for axis in "xyz"])
    error = mag - np.column_stack([columns[f"true_field_{axis}_nT"] for axis in "xyz"])
    step = SENSORS[kind].tables(RATE_HZ).get("quantisation", {"step_nT": 0.0})["step_nT"]
    expected = np.sqrt(np.square(REST_NT[kind]) + step**2 / 12)
    np.testing.assert_allclose(error.std(axis=0), expected, rtol=5 / np.sqrt(2 * len(mag)))
    if step:
        np.testing.assert_allclose(mag / step, np.round(mag / step), atol=1e-6)


def test_a_density_is_the_spectrums() -> None:
    columns = recorded(named("mag_03"))
    _, power = signal.welch(columns["mag_x_nT"] - columns["true_field_x_nT"], RATE_HZ, nperseg=256)
    assert np.sqrt(power[5:-5].mean()) == pytest.approx(0.006, rel=0.05)


def test_each_run_has_another_unit_within_the_tolerance() -> None:
    scenario = named("bmm350")
    offsets = [offset_nT(plan(scenario, run)) for run in range(60)]
    assert stats.kstest(np.ravel(offsets), stats.norm(0, 25_000).cdf).pvalue > 1e-4
    told = plan(scenario, 3).metadata["parameters"]["drawn"]
    assert tuple(told["sensors.0.effects.sensor_offset.offset_nT"]) == offsets[3]
    scenario = named("mag_03")
    bounded = [offset_nT(plan(scenario, run)) for run in range(20)]
    assert 3.0 < np.abs(bounded).max() <= 5.0


def test_the_scenarios_own_tables_take_the_sheets_place() -> None:
    own = named("rm3100", "effects.white_noise.std_nT=3", "sensors.0.effects.nonlinearity={}")
    chain = {effect.name: effect for effect in own.chain()}
    assert chain[WhiteNoise.name] == WhiteNoise((3, 3, 3))
    assert chain[Nonlinearity.name] == Nonlinearity()
    assert not equipped(own).vary
    other = named("bmm350", 'vary."sensors.0.effects.sensor_offset.offset_nT".uniform=[-1, 1]')
    assert np.abs(offset_nT(plan(other))).max() <= 1


def test_a_kind_at_the_top_is_that_of_every_sensor_without_one() -> None:
    scenario = load("gradiometer-turntable", ["sensor.kind=bmm350", "sensors.1.kind=rm3100"])
    assert [scenario.sheet(k) for k in range(4)] == [SENSORS[kind] for kind in ("bmm350", "rm3100", "bmm350", "bmm350")]
    assert len({offset_nT(plan(scenario), sensor) for sensor in (0, 2, 3)}) == 3


def test_what_is_equipped_stays_as_it_is() -> None:
    scenario = named("bmm350")
    assert equipped(equipped(scenario)) == equipped(scenario) != scenario
    assert equipped(load("tumble")) == load("tumble")


BAD = {
    ("sensor.kind=rm3001",): r"sensor\.kind: no sensor 'rm3001'.*rm3100",
    ('sensors=[{kind="planet"}]',): r"sensors\.0\.kind: no sensor 'planet'.*valid: ",
    ("sensor.kind=gsm_19",): r"sensors: 1 of 1 sensors give the field's strength alone",
    ('sensors=[{}, {kind="gsm_19"}]', "sampling.rate_hz=10"): r"sampling\.rate_hz: the gsm_19 gives at most 5 samples",
    ("sensor.kind=rm3100", 'vary."sensor.kind".choice=["rm3100", "bmm350"]'): r"a kind cannot vary",
    ("sensor.kind=rm3100", 'effect_order=["white_noise"]'): r"effect_order: does not name",
    ("sensor.kind=rm3100", 'vary."sensors.0.effects.sensor_offset.offset_nT".uniform=[0, 1]'): r"no value",
}


@pytest.mark.parametrize("overrides", BAD, ids=lambda one: one[-1][:40])
def test_what_does_not_go_together_is_told(overrides: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match=BAD[overrides]):
        load("turntable-twelve-stops", ["effects=", *overrides])


def test_the_editors_schema_lists_them() -> None:
    known = json_schema()["$defs"]
    assert known["InstrumentSpec"]["properties"]["kind"]["enum"] == list(SENSORS)


def test_linearity_is_the_departure_from_the_best_line(states: Callable[..., State]) -> None:
    figure = linearity("0.5 %", 0.005, 200_000.0)
    worst = figure.spread["third_order"].uniform[1]  # type: ignore[index]
    field_nT = np.repeat(np.linspace(-200_000, 200_000, 2001)[:, None], 3, axis=1)
    effect = figure.effect(**{**figure.at(1.0), "third_order": (worst, worst, worst)})
    bent = effect.apply(states(len(field_nT)), field_nT, np.random.default_rng(0), {})[:, 0]
    best = minimize_scalar(
        lambda slope: np.abs(bent - slope * field_nT[:, 0]).max(), bounds=(-0.1, 0.1), method="bounded"
    )
    assert best.fun == pytest.approx(0.005 * 200_000, rel=1e-3)


def test_hysteresis_is_the_distance_between_the_ways(states: Callable[..., State]) -> None:
    figure = hysteresis("15 nT", 15.0)
    up = np.linspace(-50_000, 50_000, 1001)
    field_nT = np.repeat(np.concatenate([up, up[::-1], up])[:, None], 3, axis=1)
    lag = BY_NAME[figure.effect.name](**figure.at(1.0))
    late = lag.apply(states(len(field_nT)), field_nT, np.random.default_rng(0), {})[:, 0]
    down_at_zero, up_at_zero = late[1001 + 500], late[2002 + 500]
    assert down_at_zero - up_at_zero == pytest.approx(15.0)
