"""A second magnetometer as reference: what the first alone feels is named, what both feel is not there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.numerics.rates import body_rate
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.sensors import needs_field, one_sensor, recorded_reference
from diagnosis.question import Question, answer, file_sources
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from recordings import Recording, write_recording
from recordings.channels import REFERENCE
from scenarios.errors import InputError
from sim.scenario import ModelSpec, load_model
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, recording

MODEL = ModelSpec.model_validate({"effects": {"white_noise": {"std_nT": [2.0] * 3}}})
MOUNT = Rotation.from_euler("xyz", [20, -35, 100], degrees=True).as_matrix() @ np.diag([1.02, 0.97, 1.05])
OFFSET_NT = np.array([400.0, -900.0, 300.0])
GAIN = np.array([1.5, -1.0, 2.0])


def motor(gain: Any) -> dict[str, Any]:
    return {"motor_current": {"gain_nT_A": np.asarray(gain).tolist()}}


def two(hidden: dict[str, Any], other: dict[str, Any], n: int = 1200, offset: float = 1.0) -> Recording:
    """One magnetometer and a second one, which sits turned, is scaled and has hard iron, as sensors 1 and 2."""
    first, second = recording(n, seed=1, hidden=hidden), recording(n, seed=2, hidden=other)
    both = np.stack([first.mag_nT, second.mag_nT @ MOUNT.T + offset * OFFSET_NT])
    return replace(first, array_mag_nT=both, gyro_rad_s=body_rate(first))


def found(hidden: dict[str, Any], other: dict[str, Any], **more: Any):  # type: ignore[no-untyped-def]
    return diagnose(one_sensor(two(hidden, other, **more), 1, 2, Path("log.csv")), MODEL, field_enu_nT=FIELD_ENU_NT)


def test_what_the_first_alone_feels_is_named_in_its_own_axes() -> None:
    told = found(motor(GAIN), {})
    (one,) = told.named
    assert (told.verdict, one.name) == ("named", "motor_current")
    assert (np.abs(one.effect.gain_nT_A - GAIN) < 4 * one.spread["gain_nT_A"]).all()
    assert told.gap.noise_nT == pytest.approx(np.sqrt(2) * NOISE_NT, rel=0.05)
    assert any("regional_field (no attitude)" in line for line in told.untested)


def test_a_stated_error_of_the_attitude_is_none_beside_a_reference_that_turns_along() -> None:
    scenario = load_model("auv-spiral-excited")
    assert scenario.navigation.attitude_noise_std_deg > 0  # type: ignore[union-attr]
    beside = pose_model(one_sensor(two({}, {}), 1, 2, Path("log.csv")), scenario, FIELD_ENU_NT, None)
    alone = pose_model(recording(1200), scenario, FIELD_ENU_NT, None)
    assert (beside.attitude_std_rad, beside.iron_known) == (0.0, False)
    assert alone.attitude_std_rad == np.radians(scenario.navigation.attitude_noise_std_deg)  # type: ignore[union-attr]
    assert alone.iron_known


def test_what_the_second_alone_feels_has_the_other_sign() -> None:
    (one,) = found({}, motor(GAIN)).named
    assert (np.abs(one.effect.gain_nT_A + GAIN) < 4 * one.spread["gain_nT_A"]).all()


def test_what_both_feel_alike_is_not_seen() -> None:
    told = found(motor(GAIN), motor(GAIN))
    assert (told.verdict, told.named) == ("none", ())


def test_the_currents_of_turning_are_told_though_the_reference_has_iron() -> None:
    matrix = [[3e-3, 6e-4, 0.0], [0.0, 2e-3, 3e-4], [4e-4, 0.0, 3e-3]]
    (one,) = found({"eddy_current": {"matrix_s": matrix}}, {}, offset=15.0).named
    assert one.name == "eddy_current"
    assert np.abs(np.array(one.effect.matrix_s) - matrix).max() < 2e-4


def test_attitude_and_position_are_not_used() -> None:
    posed_one = pose_model(one_sensor(two({}, {}, 300), 1, 2, Path("log.csv")), MODEL, FIELD_ENU_NT, None)
    assert posed_one.relative
    assert not posed_one.iron_known
    assert not {"attitude", "position"} & posed_one.inputs
    assert not set(REFERENCE) & set(posed_one.state.channels)
    np.testing.assert_allclose(posed_one.turn, np.eye(3))


def test_what_a_model_says_of_the_earths_frame_is_left_out() -> None:
    gradient = {"field_gradient": {"gradient_nT_m": [[1.0, 2.0, 3.0], [2.0, 1.0, 4.0], [3.0, 4.0, -2.0]]}}
    stated = ModelSpec.model_validate({"effects": gradient})
    given = one_sensor(two({}, {}, 300), 1, 2, Path("log.csv"))
    assert pose_model(given, stated, FIELD_ENU_NT, None).effects == ()


def test_a_file_by_an_array_is_compared_with_one_of_its_sensors(tmp_path: Path) -> None:
    path = tmp_path / "boom.parquet"
    write_recording(two(motor(GAIN), {}, 600), path)
    (source,) = file_sources([path], None, reference_sensor=2)
    assert (source.name, source.sensor, source.reference_sensor) == ("boom@1", 1, 2)
    told = answer(Question.about(None), [source])
    assert isinstance(told, Diagnosis)
    assert told.problem.relative
    assert [one.name for one in told.named] == ["motor_current"]
    with pytest.raises(InputError, match="a field is stated too"):
        answer(Question.about(None, field_enu_nT=FIELD_ENU_NT.tolist()), [source])


@pytest.mark.parametrize(
    ("sensor", "reference", "message"),
    [(1, 1, "no reference of itself"), (1, 3, "no sensor 3"), (None, 2, "array of 2 sensors")],
)
def test_a_reference_that_is_none_is_one_line(sensor: int | None, reference: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        one_sensor(two({}, {}, 300), sensor, reference, Path("log.csv"))


def test_a_single_magnetometer_has_no_reference() -> None:
    one = recording(300)
    assert recorded_reference(one) is None
    assert needs_field(one, MODEL, stated=False)
    with pytest.raises(InputError, match="no reference of itself"):
        one_sensor(one, None, 1, Path("log.csv"))


def test_of_columns_of_a_reference_no_sensor_is_asked_for() -> None:
    one = one_sensor(two({}, {}, 300), 1, 2, Path("log.csv"))
    with pytest.raises(InputError, match=r"leave the option out: reference_x_nT"):
        one_sensor(replace(one, array_mag_nT=None), None, 2, Path("log.csv"))


def test_a_reference_has_three_axes_with_a_field_in_every_row() -> None:
    one = one_sensor(two({}, {}, 300), 1, 2, Path("log.csv"))
    first, *others = REFERENCE
    with pytest.raises(InputError, match=f"no column {others[0]} beside {first}"):
        recorded_reference(replace(one, channels={first: one.channels[first]}))
    with pytest.raises(InputError, match="rows without a field"):
        recorded_reference(replace(one, channels=dict.fromkeys(REFERENCE, np.zeros(300))))
