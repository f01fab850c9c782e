"""The sensors of one array: a disturbance that all feel alike, one that differs, one of a single sensor, and none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.problem.formulation import pose_model
from diagnosis.problem.sensors import model_of_sensor, of_sensor
from diagnosis.question import Question, answer, check_single, file_sources, of_one_array
from diagnosis.result import Transfer
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import PooledDiagnosis, worst
from diagnosis.several.workflow import diagnose_sensors
from diagnosis.verdict import Verdict
from recordings import Recording, write_recording
from scenarios.errors import InputError
from sim.scenario import ModelSpec, Scenario, load
from tests.diagnosis.several.test_workflow import motor
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, recording
from tests.results import check_printed

MODEL = ModelSpec.model_validate({"effects": {"white_noise": {"std_nT": [2.0] * 3}}})


def array(*hidden: dict[str, Any], n: int = 1000) -> Recording:
    """One recording by an array whose sensors have these effects."""
    each = [recording(n, seed=i, hidden=one) for i, one in enumerate(hidden)]
    return replace(each[0], array_mag_nT=np.stack([one.mag_nT for one in each]))


def sensors(*hidden: dict[str, Any]) -> PooledDiagnosis:
    whole = array(*hidden)
    several = [of_sensor(whole, k + 1, "test") for k in range(len(hidden))]
    problems = [pose_model(one, MODEL, FIELD_ENU_NT, None, iron_known=False) for one in several]
    names = [f"dive@{k + 1}" for k in range(len(hidden))]
    return diagnose_sensors(names, problems, [MODEL] * len(hidden), without=ALL_BUT_SEVEN)


def test_what_all_feel_alike_comes_from_far() -> None:
    found = sensors(motor(1.0), motor(1.0))
    (one,) = found.common
    assert (found.verdict, one.name, one.transfer) == (Verdict.NAMED, "motor_current", Transfer.TRANSFERRED)
    assert "far away" in found.advice[0]
    check_printed(["diagnose"], found.as_dict())
    (told,) = found.as_dict()["effects"]
    assert (told["evidence"], told["among_sensors"]) == ("single-run", "the same")


def test_what_differs_comes_from_near_also_with_the_other_sign() -> None:
    found = sensors(motor(1.0), motor(-0.5))
    (one,) = found.common
    assert one.transfer is Transfer.NOT_TRANSFERRED
    assert "dive@2 has least, dive@1 2" in found.advice[0]
    assert [each["verdict"] for each in found.as_dict()["sensors"]] == ["named", "named"]


def test_what_one_sensor_shows_is_its_own_and_makes_the_headline() -> None:
    found = sensors({}, motor(1.0))
    assert found.common == ()
    (one,) = found.single
    assert one.presence == (Presence.ABSENT, Presence.PRESENT)
    assert found.as_dict()["worst"] == "dive@2"
    assert found.sentence.startswith("dive@2, of 2 sensors (1 none, 1 named): Missing in the model: motor_current")
    assert "not in dive@1" in found.advice[0]


def test_the_worst_is_what_leaves_most_without_a_cause_else_the_largest_gap() -> None:
    def one(verdict: Verdict, before_sigma: float, after_sigma: float) -> Any:
        return SimpleNamespace(verdict=verdict, gap=SimpleNamespace(before_sigma=before_sigma, after_sigma=after_sigma))

    named, none = one(Verdict.NAMED, 9.0, 1.0), one(Verdict.NONE, 1.0, 1.0)
    assert worst([named, one(Verdict.UNKNOWN, 4.0, 2.0), one(Verdict.PARTIAL, 8.0, 3.0)]) == 2
    assert worst([none, one(Verdict.NAMED, 2.0, 1.0), named]) == 2
    assert worst([none, none]) == 0


def test_each_effect_is_compared_beside_all_others() -> None:
    """One sensor feels the temperature five times as much as the current: its gain is known as well all the same."""
    warm = {"temperature_offset": {"slope_nT_K": [30.0, -20.0, 25.0]}}
    found = sensors(motor(1.0) | warm, motor(1.0))
    (one,) = (one for one in found.common if one.name == "motor_current")
    both, alone = (each.spread["gain_nT_A"] for each in one.each if each is not None)
    assert both == pytest.approx(alone, rel=0.3)


def test_an_array_without_a_disturbance_has_none() -> None:
    found = sensors({}, {})
    assert (found.verdict, found.common, found.single) == (Verdict.NONE, (), ())


def test_a_file_by_an_array_is_its_sensors_unless_one_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "dive.parquet"
    write_recording(array(motor(1.0), {}, n=400), path)
    found = file_sources([path], None)
    assert [(one.name, one.sensor) for one in found] == [("dive@1", 1), ("dive@2", 2)]
    assert of_one_array(found)
    assert answer(Question.about(None, field_enu_nT=FIELD_ENU_NT.tolist()), found).as_dict()["worst"] == "dive@1"
    assert [(one.name, one.sensor) for one in file_sources([path], None, sensor=2)] == [("dive", 2)]
    with pytest.raises(InputError, match=r"2 sensors among several recordings.*--sensor"):
        file_sources([path, path], None)
    assert not of_one_array(file_sources([path, path], None, sensor=1))
    with pytest.raises(InputError, match="--confirm: needs one sensor"):
        check_single(found, "--confirm")
    with pytest.raises(InputError, match="give one, or all"):
        check_single(file_sources([path, path], None, sensor=1), "--confirm")


@pytest.mark.parametrize(
    ("sensor", "message"), [(None, "array of 2 sensors.*--sensor"), (3, "no sensor 3.*the sensors 1 to 2")]
)
def test_a_sensor_that_is_not_there_is_one_line(sensor: int | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        of_sensor(array({}, {}, n=200), sensor, "log.csv: --sensor")


def test_a_single_magnetometer_is_sensor_one() -> None:
    one = recording(200)
    assert of_sensor(one, 1, "test") is one
    with pytest.raises(InputError, match=r"one magnetometer \(leave the option out\)"):
        of_sensor(one, 2, "test")


def test_a_scenario_is_each_sensors_own() -> None:
    whole = load("gradiometer-turntable")
    own = model_of_sensor(whole, 3)
    assert isinstance(own, Scenario)
    assert own.chain() == whole.chain(2) != whole.chain(0)
    assert model_of_sensor(MODEL, 3) is MODEL
    varied = whole.model_copy(update={"vary": {"seed": None}})
    alone = model_of_sensor(varied, 3)
    assert isinstance(alone, Scenario)
    assert not alone.vary
