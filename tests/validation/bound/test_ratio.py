"""Ratios of scores to the bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import CALIBRATORS
from scenarios.errors import InputError
from scenarios.toml import as_dict
from sim.effects.noise import FLICKER_LOW_HZ, FlickerNoise, WhiteNoise
from sim.scenario import Scenario, load
from sim.simulation import plan
from validation.bound.files import run_experiment
from validation.bound.ratio import bound_ratio, knowledge_of, least_errors
from validation.bound.runs import RunBounds
from validation.calibrating.selection import select_calibrators

SHORT = ["phases.0.duration_s=120"]


def drawn(scenario: Scenario, vary: dict[str, dict[str, list[float]]]) -> Scenario:
    return Scenario.model_validate(as_dict(scenario) | {"vary": vary})


def told(name: str, *, eddy: bool = False) -> str | None:
    needs = CALIBRATORS[name.split("@")[0]].needs
    return knowledge_of(name, needs, attitude_free="attitude" not in needs, eddy=eddy)


def test_what_a_calibrator_is_told_follows_from_what_it_needs() -> None:
    assert told("ellipsoid") == "norm"
    assert told("vector_least_squares") == "vector"
    assert told("vector_lm", eddy=True) == "vector+eddy"
    assert told("gyro_ml") == "norm+gyro"
    assert told("gyro_accel_ml") == "norm+gyro+accel"
    assert told("ellipsoid@2") is None
    assert {told(name) for name, one in CALIBRATORS.items() if "array" in one.needs} == {None}


@pytest.mark.parametrize(
    ("said", "knowledge"),
    [("mine", "norm"), ("mine:gyro", "norm+gyro"), ("mine:accel,gyro", "norm+gyro+accel"), ("mine:accel", None)],
)
def test_a_program_is_told_what_its_user_says(said: str, knowledge: str | None) -> None:
    (one,) = select_calibrators((), (f"{said}=true {{recording}} {{result}}",))
    assert one.name == "mine"
    assert knowledge_of(one.name, one.needs, attitude_free=one.attitude_free) == knowledge
    (by_attitude,) = select_calibrators((), ("mine:attitude=true {recording} {result}",))
    assert not by_attitude.attitude_free


def test_a_program_cannot_need_what_is_no_part_of_a_recording() -> None:
    with pytest.raises(InputError, match="gyro, accel, attitude"):
        select_calibrators((), ("mine:giro=true {recording} {result}",))


@pytest.mark.parametrize("std_nT", [10.0, 0.0])
def test_the_least_offset_error_is_the_standard_s_where_there_is_noise(std_nT: float) -> None:
    scenario = load("standard-full", [f"effects.white_noise.std_nT=[{std_nT}, {std_nT}, {std_nT}]"])
    least = RunBounds(scenario, 0, frozenset({"norm", "vector"})).of(0)
    if std_nT == 0:
        assert least == {}
        return
    # flown: 3800 samples for 3600, and the first of them on the way into the motion
    assert least["norm", "offset_error_nT"] == pytest.approx(0.5592, rel=0.05)
    assert least["vector", "offset_error_nT"] == pytest.approx(0.2938, rel=0.05)


def test_noise_that_lasts_is_in_the_bound_of_all_that_is_told() -> None:
    """While the sensor tumbles its offset is the mean of the noise: for density d^2 / f the integral with sinc^2."""
    scenario = load("tumble")
    words = ("norm", "norm+gyro", "norm+gyro+accel", "vector", "vector+eddy")
    least = RunBounds(scenario, 0, frozenset(words)).of(0)
    norm, gyro, both, vector, eddy = (least[word, "offset_error_nT"] for word in words)
    known = run_experiment(plan(scenario))
    (flicker,) = (one for one in plan(scenario).effects[0] if isinstance(one, FlickerNoise))
    hz = np.geomspace(1e-7, 5.0, 100_000)
    density = np.mean(np.square(flicker.density_nT_sqrt_hz)) / np.maximum(hz, FLICKER_LOW_HZ)
    mean_square = 3.0 * np.trapezoid(density * np.sinc(hz * known.step_s.sum()) ** 2, hz)
    assert vector == pytest.approx(np.sqrt(mean_square), rel=0.1)
    assert vector <= eddy < norm < 1.1 * vector
    white = least_errors(replace(known, colour=None), {"norm+gyro"})["norm+gyro", "offset_error_nT"]
    assert 5.0 * white < gyro <= vector
    assert gyro == pytest.approx(both)


def test_each_run_has_the_bound_of_its_own_noise() -> None:
    """Half the noise, half the error; runs that differ in the noise's draws alone share one bound."""
    plain = load("standard-full", SHORT)
    alike = RunBounds(plain, 0, frozenset({"norm"}))
    assert alike.of(0) is alike.of(7)
    noisy = drawn(plain, {"effects.white_noise.std_nT": {"uniform": [1.0, 100.0]}})
    bounds = RunBounds(noisy, 0, frozenset({"norm"}))
    for run in range(3):
        std_nT = next(np.array(one.std_nT) for one in plan(noisy, run, 0).effects[0] if isinstance(one, WhiteNoise))
        ratio = bounds.of(run)["norm", "offset_error_nT"] / alike.of(0)["norm", "offset_error_nT"]
        assert ratio == pytest.approx(np.sqrt(np.mean(std_nT**2)) / 10.0, rel=1e-6)


def test_nothing_is_flown_where_nothing_is_asked() -> None:
    assert RunBounds(load("standard-full"), 0, frozenset()).of(0) == {}


def test_a_ratio_is_of_the_rms_over_trials_with_an_estimate() -> None:
    least = np.array([2.5, 1.0, 2.5])
    assert bound_ratio(np.array([3.0, np.nan, 4.0]), least) == pytest.approx(np.sqrt(2.0))
    assert bound_ratio(np.array([3.0, 2.0]), np.array([3.0, np.nan])) == pytest.approx(1.0)
    assert bound_ratio(np.array([1.0, 2.0]), np.array([2.0, 1.0])) == pytest.approx(np.sqrt((0.25 + 4.0) / 2))
    assert bound_ratio(np.array([np.nan]), np.ones(1)) is None
    assert bound_ratio(np.ones(2), np.array([np.inf, np.nan])) is None
