"""What is possible, from Python: bound, plan and worth on scenarios and data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import magbench
from magbench import InputError
from magbench.api.planning_results import OnwardResult, PlanResult
from tests.magbench.test_api import STRENGTH_NT, as_csv, measured
from validation.bound.query import BoundQuery
from validation.planning import refinement

SHORT = "phases.0.duration_s=60"


def test_the_bound_of_a_scenario_by_name_or_loaded_shows_itself() -> None:
    found = magbench.bound("standard-full", "vector", overrides=[SHORT])
    other = magbench.bound(magbench.load("standard-full", [SHORT]), "vector")
    assert found.bound.offset_rms_nT == other.bound.offset_rms_nT
    assert found.bound.offset_rms_nT == BoundQuery("vector").of_scenario(other_scenario()).bound.offset_rms_nT
    assert "no method can find the offset" in repr(found)
    assert found.to_frame().shape == (3, 4)
    assert found.plot().axes


def other_scenario() -> magbench.Scenario:
    return magbench.load("standard-full", [SHORT])


def test_the_bound_of_data_and_of_its_file_are_one(tmp_path: Path) -> None:
    in_memory = magbench.bound({"time_s": 0.1 * np.arange(500), **fields()}, field_strength_nT=STRENGTH_NT)
    of_file = magbench.bound(as_csv(measured(), tmp_path), field_strength_nT=STRENGTH_NT)
    assert in_memory.bound.offset_rms_nT == pytest.approx(of_file.bound.offset_rms_nT, rel=1e-6)
    assert in_memory.bound.offset_rms_nT == pytest.approx(5 * np.sqrt(3 * 3 / 500), rel=0.3)


def fields() -> dict[str, np.ndarray]:
    return {f"mag_{axis}_nT": measured()[:, k] for k, axis in enumerate("xyz")}


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"source": "standard-ful"}, "no such file"),
        ({"source": "standard-full", "knowledge": "all"}, "knowledge: 'all'"),
        ({"source": "standard-full", "tilt_limits": (200, 5)}, "tilt_limits: 200,5 is no pair"),
        ({"source": measured(), "coloured": True}, "this is a recording"),
        ({"source": measured()}, "give field_strength_nT"),
    ],
)
def test_a_mistake_is_told_by_its_argument(arguments: dict[str, object], told: str) -> None:
    with pytest.raises(InputError, match=told) as error:
        magbench.bound(**arguments)  # type: ignore[arg-type]
    assert "--" not in str(error.value)


@pytest.fixture
def searched_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Attitudes moved in one round: how near to the limit a plan comes is asked in `tests/validation/planning`."""
    monkeypatch.setattr(refinement, "STEPS_DEG", refinement.STEPS_DEG[:1])
    monkeypatch.setattr(refinement, "MOST_ROUNDS", 1)


@pytest.mark.usefixtures("searched_once")
def test_a_plan_is_flown_by_its_scenario() -> None:
    found = magbench.plan("turntable", 40, knowledge="vector")
    assert isinstance(found, PlanResult)
    assert len(found.to_frame()) == len(found.choice.legs)
    assert found.plot().axes
    assert magbench.simulate(found.scenario)[0].time_s[-1] == pytest.approx(found.time_s, abs=1.0)
    assert "nT" in repr(found)


@pytest.mark.usefixtures("searched_once")
def test_after_a_recording_legs_go_on() -> None:
    recording = magbench.simulate("auv-spiral", overrides=["phases.0.duration_s=120"])[0]
    field = magbench.load("auv-spiral").field
    enu = magbench.bound("auv-spiral", "vector", overrides=["phases.0.duration_s=120"]).known.field_enu_nT
    assert field is not None
    found = magbench.plan("auv", 60, after=recording, knowledge="vector", field_enu_nT=enu)
    assert isinstance(found, OnwardResult)
    assert found.legs[0].after < found.legs[0].before
    assert len(found.to_frame()) > 0
    assert found.plot().axes


def test_what_is_worth_it() -> None:
    told = magbench.worth(measured(), STRENGTH_NT)
    (found,) = told
    assert found.pairs[0].verdict == "worth_it"
    assert "Held out in turn" in repr(told)
    assert "array" not in repr(told)
    assert told._repr_html_().count("<p>") == len(repr(told).splitlines())
