"""What is said before a verdict where the stated strength is wrong, or the axes are others."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.decision.remarks import (
    axis_permutation,
    iron_remark,
    mount_remark,
    reference_remarks,
    strength_residuals_nT,
)
from diagnosis.evidence.baseline import Baseline
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim import effects as effect_table
from sim.scenario import ModelSpec
from tests.diagnosis.decision.answers import IRON as CHANGED
from tests.diagnosis.decision.answers import diagnosis_of
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, STRENGTH_NT, recording, without_attitude
from validation.axes.maps import TURNS

MAPS = [*TURNS, *-TURNS]
"""The 48 matrices that map axes to axes: 24 rotations and 24 reflections."""
IRON: dict[str, Any] = {
    "soft_iron": {"matrix": [[0.03, 0.02, -0.01], [0.01, -0.03, 0.01], [-0.01, 0.02, 0.02]]},
    "hard_iron": {"offset_nT": [300.0, -200.0, 150.0]},
}
CURRENT = {"motor_current": {"gain_nT_A": [20.0, -10.0, 15.0]}}


def _flown(far_m: float, up_m: float, structure_nT: float, **changes: Any) -> Any:
    """A straight way in 1 nT of noise, beside one given vector of 50 000 nT."""
    pos = np.outer([0.0, 1.0], [far_m, 0.0, up_m])
    state = SimpleNamespace(pos_enu_m=pos, field_enu_nT=np.array([0.0, 0.0, 5e4]))
    gap = SimpleNamespace(structure_nT=(structure_nT, 0.0), noise_nT=1.0)
    posed = {
        "policy": STANDARD,
        "track": None,
        "relative": False,
        "still": False,
        "inputs": {"position"},
        "corrections": (),
        "state": state,
    }
    problem = SimpleNamespace(**posed | {"recording": SimpleNamespace(channels={})} | changes)
    return SimpleNamespace(problem=problem, gap=gap, verdict=Verdict.UNKNOWN)


@pytest.mark.parametrize("attitude", [True, False])
@pytest.mark.parametrize(("off_nT", "told"), [(1.0, False), (20.0, True)])
def test_a_model_whose_iron_does_not_fit_is_told_so(off_nT: float, told: bool, attitude: bool) -> None:
    """In 2 nT of noise; where a name says so it is not said again."""
    given = recording(hidden={"hard_iron": {"offset_nT": [off_nT, -off_nT, off_nT]}})
    posed = pose(given if attitude else without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT))
    left_nT = Baseline.of(posed).residual() * posed.sigma_nT
    bare: Any = SimpleNamespace(chain=tuple)
    found = diagnosis_of(Verdict.NAMED, problem=posed, model=bare, after_nT=left_nT)
    assert any("the iron has changed" in line for line in iron_remark(found)) is told
    assert not list(iron_remark(replace(found, named=(CHANGED,))))


@pytest.mark.parametrize(
    ("far_m", "structure_nT", "told"), [(1e3, 10.0, True), (1e3, 30.0, False), (190.0, 0.1, False), (210.0, 0.1, True)]
)
def test_a_path_is_long_where_the_field_changes_by_a_share_of_the_gap_and_by_the_noise(
    far_m: float, structure_nT: float, told: bool
) -> None:
    """By 5 nT a kilometre; and by 0.024 nT a metre of height, of a dipole."""
    assert bool(list(reference_remarks(_flown(far_m, 0.0, structure_nT)))) is told
    assert bool(list(reference_remarks(_flown(0.0, far_m * 0.005 / (3 * 5e4 / 6.371e6), structure_nT)))) is told


@pytest.mark.parametrize(
    ("changes", "far", "up"),
    [
        ({}, True, True),
        ({"track": "known"}, False, False),
        ({"inputs": set()}, False, False),
        ({"relative": True}, True, False),
        ({"still": True}, True, False),
    ],
)
def test_a_long_way_is_told_where_one_vector_was_given_for_all_of_it(
    changes: dict[str, Any], far: bool, up: bool
) -> None:
    """Another magnetometer flies along, and at rest nothing was given."""
    found = _flown(1e5, 1e5, 10.0, **changes)
    told = " ".join(words for words, _ in reference_remarks(found))
    assert ("The path is" in told, "The log spans" in told) == (far, up)
    found.verdict = Verdict.NONE
    assert not list(reference_remarks(found))


def test_a_height_is_read_where_it_is_known() -> None:
    log = SimpleNamespace(channels={"altitude_m": np.array([np.nan, 100.0, 9e4])})
    assert "89.9 km of height" in next(reference_remarks(_flown(0.0, 0.0, 10.0, recording=log)))[0]


def _posed(hidden: dict[str, Any], *, stated: float, iron_known: bool = True) -> LinearProblem:
    """A log without attitude beside a model that knows its iron, the strength stated as a multiple of the true one."""
    given = without_attitude(recording(hidden=IRON | hidden))
    problem = pose(given, Known(None, STRENGTH_NT * stated, tuple(effect_table.build(IRON, None, "test"))))
    return replace(problem, iron_known=iron_known)


@pytest.mark.parametrize("hidden", [{}, CURRENT], ids=["alone", "beside a current"])
def test_a_strength_that_is_two_percent_off_is_told_as_such(hidden: dict[str, Any]) -> None:
    given_nT, _, factor = strength_residuals_nT(_posed(hidden, stated=1.02))
    assert factor == pytest.approx(1 / 1.02, abs=2e-3)
    assert given_nT == pytest.approx(0.02 * STRENGTH_NT, rel=0.1)


@pytest.mark.parametrize("hidden", [{}, CURRENT, {"hard_iron_drift": {"rate_nT_h": [500.0, 300.0, -200.0]}}])
def test_a_right_strength_is_not_doubted(hidden: dict[str, Any]) -> None:
    assert strength_residuals_nT(_posed(hidden, stated=1.0))[2] is None


def test_without_the_models_iron_a_factor_cannot_be_told() -> None:
    unknown = _posed({}, stated=1.02, iron_known=False)
    assert not list(iron_remark(diagnosis_of(Verdict.NAMED, problem=unknown)))


def _along(axes: list[list[float]], model: dict[str, Any]) -> Diagnosis:
    """A log whose magnetometer has other axes than the body, beside a model."""
    given = recording(1000, hidden=IRON)
    turned = replace(given, mag_nT=given.mag_nT @ np.array(axes, dtype=float).T)
    spec = ModelSpec.model_validate({"effects": model})
    return diagnose(turned, spec, field_enu_nT=FIELD_ENU_NT, fitted_base=not model, without=COSTLY)


def _mounted(turn_deg: list[float], hidden: dict[str, Any]) -> Diagnosis:
    """A log whose attitude is that of axes that are turned against the body's, beside a model that knows its iron."""
    given = recording(1000, hidden=IRON | hidden)
    q = Rotation.from_quat(np.roll(given.att_q, -1, axis=1)) * Rotation.from_rotvec(turn_deg, degrees=True)
    spec = ModelSpec.model_validate({"effects": IRON})
    turned = replace(given, att_q=np.roll(q.as_quat(), 1, axis=1))
    return diagnose(turned, spec, field_enu_nT=FIELD_ENU_NT, without=COSTLY)


def test_a_mount_that_is_turned_is_told_and_iron_that_differs_is_none() -> None:
    """`att_q` times Q: ``A R^T F = A Q (R Q)^T F``, so the field of the attitude's axes is turned by Q."""
    (told,) = mount_remark(_mounted([1.5, -2.0, 3.0], {}))
    assert "a rotation by 3.91 degrees (1.50, \N{MINUS SIGN}2.00, 3.00 about" in told
    other = {"soft_iron": {"matrix": [[0.05, -0.02, 0.01], [0.03, -0.03, 0.02], [-0.01, 0.04, 0.01]]}}
    assert not list(mount_remark(_mounted([0.0, 0.0, 0.0], other)))


def test_axes_of_another_frame_are_told_by_name() -> None:
    assert "lie along the body's x, -y, -z:" in _along([[1, 0, 0], [0, -1, 0], [0, 0, -1]], {}).sentence
    assert "lie along the body's -y, x, z:" in _along([[0, -1, 0], [1, 0, 0], [0, 0, 1]], {}).sentence


def test_axes_that_are_the_bodys_or_that_the_model_knows_are_not_told() -> None:
    assert "lie along" not in _along([[1, 0, 0], [0, 1, 0], [0, 0, 1]], {}).sentence
    installed = {"misalignment": {"angles_deg": [180.0, 0.0, 0.0]}}
    assert "lie along" not in _along([[1, 0, 0], [0, -1, 0], [0, 0, -1]], installed).sentence


def _axes(swap: Array, tilt_rad: float, noise_nT: float = 0.0) -> str | None:
    """What is said of a magnetometer that measures ``swap f + b`` on a course that yaws, rolls and pitches.

    noise_nT : rms of slow noise that no iron explains.
    """
    t = np.arange(2000) / 10.0
    tilts = tilt_rad * np.column_stack([np.sin(0.17 * t), np.cos(0.23 * t)])
    turn = Rotation.from_euler("ZYX", np.column_stack([0.13 * t, tilts]))
    mag_nT = turn.inv().apply(FIELD_ENU_NT) @ swap.T + [300.0, -200.0, 150.0]
    slow_nT = noise_nT * np.sqrt(2) * np.sin(np.outer(t, [0.41, 0.37, 0.29]))
    white_nT = np.random.default_rng(0).normal(size=(len(t), 3))
    att_q = turn.as_quat(scalar_first=True)
    return axis_permutation(
        pose(Recording(t, mag_nT + slow_nT + white_nT, att_q=att_q), Known(FIELD_ENU_NT, STRENGTH_NT))
    )


@pytest.mark.parametrize("tilt_rad", [0.5, 0.1])
def test_each_of_the_48_is_told_where_three_axes_are_shown(tilt_rad: float) -> None:
    told = [_axes(swap, tilt_rad) for swap in MAPS]
    assert told[0] is None
    assert len(set(told)) == 48
    mirrored = [bool(np.linalg.det(swap) < 0) for swap in MAPS]
    assert ["mirrored (the sign" in (one or "") for one in told] == mirrored


def test_an_axis_that_is_not_shown_is_a_right_handed_sensors() -> None:
    assert _axes(np.diag([1.0, 1.0, -1.0]), 0.003) is None
    for mirrored in (np.diag([1.0, -1.0, 1.0]), np.diag([1.0, -1.0, -1.0])):
        told = _axes(mirrored, 0.003)
        assert told is not None
        assert told.startswith("x, -y, -z (or mirrored, or the attitude is inverted")


def test_what_no_iron_explains_may_hide_a_sign() -> None:
    down = np.diag([1.0, 1.0, -1.0])
    assert _axes(down, 0.1) is not None
    assert _axes(down, 0.1, noise_nT=1500.0) is None


def test_time_stamps_in_milliseconds_are_told() -> None:
    given = recording(1000)
    in_ms = replace(given, time_s=1e3 * given.time_s)
    for one, told in ((given, 0), (in_ms, 1)):
        model = ModelSpec.model_validate({"effects": {}})
        found = diagnose(one, model, field_enu_nT=FIELD_ENU_NT, fitted_base=True)
        assert found.sentence.count("unit=ms") == told


@pytest.mark.parametrize(("off_deg", "told"), [(15.0, True), (25.0, False)])
def test_a_sensor_lies_along_other_axes_within_twenty_degrees(off_deg: float, told: bool) -> None:
    aside = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turn = Rotation.from_euler("x", off_deg, degrees=True).as_matrix()
    assert (_axes(aside @ turn, 0.5) is not None) is told


@pytest.mark.parametrize(("noise_share", "told"), [(2.5, False), (1.5, True)])
def test_a_strength_is_another_where_iron_fitted_anew_leaves_a_tenth_less(noise_share: float, told: bool) -> None:
    """Off by 100 nT beside so many times that in noise, which no iron takes up."""
    given = recording(noise_nT=100.0 * noise_share, hidden=IRON)
    posed = pose(
        without_attitude(given), Known(None, STRENGTH_NT + 100.0, tuple(effect_table.build(IRON, None, "test")))
    )
    assert (strength_residuals_nT(replace(posed, iron_known=True))[2] is not None) is told
