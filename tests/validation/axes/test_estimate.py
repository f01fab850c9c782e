"""Axis maps named from gyro, accelerometer and attitude, on motions made of sums of sines."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.axes_alarms import INSTRUMENTS, MAPS, Conditions, outcome, random_conditions, simulated
from recordings import read_recording
from scenarios.arrays import Array
from validation.axes.estimate import Axes, axes_of
from validation.axes.maps import TURNS, map_text
from validation.axes.policy import AXES
from validation.axes.rows import rows_of

TUMBLED = Conditions()


def same(found: list[Array], wanted: list[Array]) -> bool:
    return sorted(map(map_text, found)) == sorted(map(map_text, wanted))


def estimated(given: Conditions, taken: Array, instruments: tuple[str, ...], seed: int = 1) -> Axes:
    return simulated(np.random.default_rng(seed), given).axes(taken, instruments)


def test_the_maps() -> None:
    assert len({map_text(one) for one in MAPS}) == 48
    np.testing.assert_allclose(np.linalg.det(TURNS), 1)
    assert {map_text(one) for turn in TURNS for one in (turn, -turn)} == {map_text(one) for one in MAPS}
    assert map_text(np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])) == "y,x,-z"


@pytest.mark.parametrize("taken", MAPS, ids=map_text)
def test_every_map_is_named_with_the_sign_by_the_accelerometer(taken: Array) -> None:
    """A field reversed in all three axes looks like one from the other hemisphere: it is taken as logged."""
    found = estimated(TUMBLED, taken, ("gyro", "accel"))
    assert same(found.maps, [np.eye(3) if map_text(taken) == "-x,-y,-z" else taken])
    assert found.assumed


@pytest.mark.parametrize("taken", MAPS[::5], ids=map_text)
def test_a_gyro_alone_leaves_the_reflection(taken: Array) -> None:
    if abs(np.trace(taken)) < 3:
        assert same(estimated(TUMBLED, taken, ("gyro",)).maps, [taken, -taken])


@pytest.mark.parametrize("taken", MAPS[::5], ids=map_text)
def test_an_attitude_tells_the_sign_by_the_north_component(taken: Array) -> None:
    found = estimated(TUMBLED, taken, ("q",))
    assert same(found.maps, [np.eye(3) if map_text(taken) == "-x,-y,-z" else taken])
    assert not found.assumed or found.agree


@pytest.mark.parametrize("taken", [MAPS[k] for k in (0, 9, 22, 31, 47)], ids=map_text)
def test_a_known_hemisphere_tells_a_reversed_field(taken: Array) -> None:
    log = simulated(np.random.default_rng(3), TUMBLED)
    assert same(log.axes(taken, ("gyro", "accel"), down=True).maps, [taken])
    assert same(log.axes(taken, ("gyro", "accel"), down=False).maps, [-taken])


@pytest.mark.parametrize(
    "changed",
    [
        {"gain": 180 / np.pi}, {"gain": 1e3}, {"hard": 12.0}, {"soft": 0.2}, {"bias_rad_s": 0.1}, {"late_s": 0.2},
        {"late_s": -0.2}, {"rate_hz": 8.0, "rate_rad_s": 1.5}, {"noise_nT": 2000.0}, {"rate_rad_s": 0.1},
        {"motion": "vehicle", "rows": 2000}, {"motion": "vehicle", "tilt_deg": 8.0, "rows": 2000},
    ],
    ids=str,
)  # fmt: skip
def test_the_gyro_names_the_map_in_spite_of(changed: dict[str, float | str]) -> None:
    taken = MAPS[14]
    found = estimated(replace(TUMBLED, **changed), taken, ("gyro",))  # type: ignore[arg-type]
    assert same(found.maps, [taken, -taken])


@pytest.mark.parametrize("unit", [1.0, 180 / np.pi, 1e3])
def test_the_gain_of_the_gyro(unit: float) -> None:
    found = estimated(replace(TUMBLED, gain=unit), np.eye(3), ("gyro",)).gyro
    assert found is not None
    assert found.gain[0] * unit == pytest.approx(1.0, abs=0.1)


def test_a_gyro_of_opposite_sense() -> None:
    found = estimated(replace(TUMBLED, gain=-1.0), np.eye(3), ("gyro",))
    assert found.gyro is not None
    assert found.gyro.reversed
    assert not found.speaking


@pytest.mark.parametrize("taken", MAPS[::7], ids=map_text)
def test_a_turntable_leaves_every_turn_about_the_axis(taken: Array) -> None:
    """The table's axis is the body's z: a quarter turn about z changes nothing that a gyro sees."""
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    given = replace(TUMBLED, motion="turntable", rows=1200, tilt_deg=0.0)
    level = simulated(np.random.default_rng(5), given)
    found = level.axes(taken, ("gyro",))
    assert not found.decided
    assert any(same([one], [taken]) or same([one], [-taken]) for one in found.maps)
    assert any(same([one], [quarter @ taken]) or same([one], [-quarter @ taken]) for one in found.maps)


@pytest.mark.parametrize("instruments", INSTRUMENTS, ids="+".join)
@pytest.mark.parametrize("seed", range(6))
def test_a_vehicle_that_hardly_turns_is_not_decided(seed: int, instruments: tuple[str, ...]) -> None:
    given = replace(TUMBLED, motion="still", noise_nT=300.0, shaking_m_s2=0.3)
    taken = MAPS[seed * 7]
    assert outcome(estimated(given, taken, instruments, seed), taken) in ("undetermined", "narrowed")


@pytest.mark.parametrize("logs", [25, pytest.param(160, marks=pytest.mark.slow)])
def test_a_wrong_map_is_rarely_named(logs: int) -> None:
    """Over the range of conditions; `benchmarks.axes_alarms` counts more of them."""
    counts: Counter[str] = Counter()
    for seed in range(logs):
        rng = np.random.default_rng([11, seed])
        log, taken = simulated(rng, random_conditions(rng)), MAPS[rng.integers(len(MAPS))]
        counts.update(outcome(log.axes(taken, instruments), taken) for instruments in INSTRUMENTS)
    assert counts["wrong"] <= 0.005 * counts.total()
    assert counts["named"] > 0.4 * counts.total()


def test_rows_without_values_and_too_few_rows() -> None:
    log = simulated(np.random.default_rng(2), TUMBLED)
    gyro = log.gyro.copy()
    gyro[::7] = np.nan
    assert axes_of(log.time_s, log.mag_nT, gyro=gyro).agree
    few = slice(0, 12)
    found = axes_of(log.time_s[few], log.mag_nT[few], gyro=gyro[few], accel=log.accel[few], q=log.q[few])
    assert not found.speaking
    assert axes_of(log.time_s, np.ones((600, 3)), gyro=log.gyro).gyro is None
    assert axes_of(log.time_s, log.mag_nT, gyro=np.zeros((600, 3))).gyro is None


AGREEING = {
    "motion-capture/trial_21.parquet": ["gyro", "attitude"],
    "motion-capture/trial_32.parquet": [],
    "quadrotor/dot1_111110.parquet": ["gyro"],
    "quadrotor/dot2_111109.parquet": ["gyro"],
    "quadrotor/dot7_111109.parquet": ["gyro"],
    "glider/five_dives.parquet": ["attitude"],
}
"""Measured recordings in the documented frames, with the instruments that exclude other maps."""


@pytest.mark.parametrize("name", AGREEING)
def test_measured_recordings_have_agreeing_axes(name: str, realdata: Path) -> None:
    log = read_recording(realdata / name)
    found = axes_of(log.time_s, log.mag_nT, gyro=log.gyro_rad_s, accel=log.accel_m_s2, q=log.att_q)
    assert found.agree
    assert set(AGREEING[name]) <= set(found.speaking)


def test_cave_compasses_have_axes_apart_from_their_accelerometers(realdata: Path) -> None:
    """Seven instruments of one design: field and gravity are logged in the axes of two chips, mounted differently."""
    names = set()
    for path in sorted((realdata / "cave-compass").glob("*.parquet")):
        log = read_recording(path)
        found = axes_of(log.time_s, log.mag_nT, accel=log.accel_m_s2)
        assert found.accel is not None
        names.add(map_text(TURNS[found.accel.evidence.best]))
    assert names == {"-y,-x,-z"}


def test_averages_over_more_rows_than_there_are_leave_enough() -> None:
    rng = np.random.default_rng(0)
    found = rows_of(np.arange(98) * 1e-4, rng.normal(size=(98, 3)), rng.normal(size=(98, 3)), averaged=True)
    assert found is not None
    assert len(found.mag) >= AXES.least_rows
