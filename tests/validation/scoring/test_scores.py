"""Scores and hold-out: zero for the truth, known values for known errors, and nothing in-sample that ranks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Calibration, Reference, Status
from recordings import Recording
from sim.effects import EFFECTS, build
from validation.calibrating.selection import select_calibrators
from validation.scoring.hold_out import (
    DIPOLE_PEAK_NT,
    Environment,
    hold_out,
    survey_line,
    uniform_attitudes,
)
from validation.scoring.scores import score, unobservable_rotation

FIELD_ENU_NT = np.array([1500.0, 27_000.0, -41_000.0])
SOFT = np.array([[0.05, 0.01, -0.02], [0.015, -0.03, 0.004], [-0.01, 0.02, 0.04]])
HARD_NT = np.array([900.0, -400.0, 1500.0])
TABLES = {"soft_iron": {"matrix": SOFT.tolist()}, "hard_iron": {"offset_nT": HARD_NT.tolist()}}
CHANNELS = {"temperature_degC": 10.0, "current_1_A": 2.0, "current_2_A": 3.0}
AROUND = Environment(FIELD_ENU_NT, time_s=100.0, channels=CHANNELS)


@pytest.fixture(scope="module")
def truth():
    return hold_out(build(TABLES, None, ""), AROUND)


@pytest.fixture(scope="module")
def recording():
    turn = uniform_attitudes(400)
    mag_nT = turn.inv().apply(FIELD_ENU_NT) @ (np.eye(3) + SOFT).T + HARD_NT
    noise_nT = np.random.default_rng(0).normal(0, 5.0, mag_nT.shape)
    return Recording(np.arange(400) / 10, mag_nT + noise_nT, att_q=turn.as_quat(scalar_first=True))


def exact(name="vector_least_squares", **changes):
    values = {"offset_nT": HARD_NT, "matrix": np.linalg.inv(np.eye(3) + SOFT)}
    return Calibration(name=name, status=Status("ok"), **(values | changes))


def values(calibration, recording, truth, attitude_free=False):
    return {s.name: s.value for s in score(calibration, recording, truth, attitude_free)}


def test_static_effects_depend_on_one_instant_alone():
    for effect in EFFECTS:
        if effect.static:
            assert (effect.stage in ("vehicle", "sensor"), effect.stochastic) == (True, False)


def test_static_truth_of_a_linear_chain_is_exact():
    tables = TABLES | {
        "misalignment": {"angles_deg": [2.0, -1.0, 3.0]},
        "scale": {"error": [0.01, -0.02, 0.03]},
        "sensor_offset": {"offset_nT": [5.0, 6.0, 7.0]},
        "motor_current": {"gain_nT_A": [1.0, 2.0, 3.0]},
        "temperature_offset": {"slope_nT_K": [1.0, 0.0, 2.0], "reference_degC": 20.0},
        "white_noise": {"std_nT": 50.0},
        "hard_iron_drift": {"rate_nT_h": [36.0, 0.0, 0.0]},
        "quantisation": {"step_nT": 100.0},
    }
    known = hold_out(build(tables, None, ""), AROUND)
    turn = Rotation.from_euler("ZYX", [3.0, -1.0, 2.0], degrees=True).as_matrix()
    scaled = np.diag([1.01, 0.98, 1.03]) @ turn
    np.testing.assert_allclose(known.matrix, scaled @ (np.eye(3) + SOFT), atol=1e-12)
    vehicle_nT = HARD_NT + 5.0 * np.array([1.0, 2.0, 3.0]) + [1.0, 0.0, 0.0]
    np.testing.assert_allclose(known.offset_nT, scaled @ vehicle_nT + [5.0 - 10.0, 6.0, 7.0 - 20.0], atol=1e-8)


def test_truth_scores_zero(truth, recording):
    got = values(exact(), recording, truth)
    for name in (
        "offset_error",
        "matrix_error",
        "holdout_sphere_norm_rms",
        "holdout_sphere_component_rms",
        "holdout_level_norm_rms",
        "holdout_level_component_rms",
        "heading_rms",
        "anomaly_rms",
        "figure_of_merit",
        "failure",
    ):
        assert got[name] == pytest.approx(0.0, abs=1e-6), name
    # the norm sees one direction of the noise only: 5 nT, slightly changed by the matrix
    assert got["in_sample_norm_rms"] == pytest.approx(5.0, rel=0.15)


def test_known_offset_error(truth, recording):
    got = values(exact(offset_nT=HARD_NT + np.array([30.0, 0.0, 40.0])), recording, truth)
    shift_nT = np.linalg.inv(np.eye(3) + SOFT) @ [30.0, 0.0, 40.0]
    assert got["offset_error"] == pytest.approx(50.0)
    assert got["offset_error_axis_rms"] == pytest.approx(50.0 / np.sqrt(3))
    for motion in ("sphere", "level"):
        assert got[f"holdout_{motion}_component_rms"] == pytest.approx(np.linalg.norm(shift_nT) / np.sqrt(3))
    # over all directions the norm sees a third of a fixed vector's square
    assert got["holdout_sphere_norm_rms"] == pytest.approx(np.linalg.norm(shift_nT) / np.sqrt(3), rel=0.05)


def test_heading_error_of_a_sideways_offset(truth, recording):
    matrix = np.linalg.inv(np.eye(3) + SOFT)
    sideways_nT = 100.0
    got = values(exact(offset_nT=HARD_NT - np.linalg.solve(matrix, [0.0, sideways_nT, 0.0])), recording, truth)
    horizontal_nT = np.linalg.norm(FIELD_ENU_NT[:2])
    assert got["heading_rms"] == pytest.approx(np.degrees(sideways_nT / horizontal_nT / np.sqrt(2)), rel=0.02)


def test_vertical_rotation_is_a_heading_error_unless_it_is_removed(truth, recording):
    turn = Rotation.from_euler("z", 2.0, degrees=True).as_matrix()
    turned = exact(matrix=turn @ np.linalg.inv(np.eye(3) + SOFT))
    kept, removed = (values(turned, recording, truth, attitude_free=free) for free in (False, True))
    assert kept["heading_rms"] == pytest.approx(2.0, rel=0.02)
    assert kept["matrix_error"] == pytest.approx(np.linalg.norm(turn - np.eye(3)))
    for name in ("heading_rms", "matrix_error", "holdout_sphere_component_rms"):
        assert removed[name] == pytest.approx(0.0, abs=1e-6)
    for name in ("holdout_sphere_norm_rms", "anomaly_rms", "offset_error"):
        assert kept[name] == pytest.approx(removed[name], abs=1e-6)


def test_procrustes_rotation_is_the_best_one():
    rng = np.random.default_rng(1)
    total = Rotation.random(rng=rng).as_matrix() @ (np.eye(3) + 0.1 * rng.normal(size=(3, 3)))
    best = unobservable_rotation(total)
    assert np.linalg.det(best) == pytest.approx(1.0)
    for _ in range(20):
        other = Rotation.from_rotvec(0.01 * rng.normal(size=3)).as_matrix() @ best
        assert np.linalg.norm(best @ total - np.eye(3)) < np.linalg.norm(other @ total - np.eye(3))


def test_anomaly_is_spoiled_by_an_uncorrected_magnetometer(truth, recording):
    raw = values(exact(offset_nT=np.zeros(3), matrix=np.eye(3)), recording, truth)
    assert raw["anomaly_rms"] > DIPOLE_PEAK_NT
    assert 0.5 * DIPOLE_PEAK_NT < np.ptp(truth.line_anomaly_nT) < 2 * DIPOLE_PEAK_NT
    there, back = np.split(truth.line_anomaly_nT, 2)
    np.testing.assert_allclose(there, back[::-1])
    assert len(survey_line()[0]) == len(truth.line_anomaly_nT)


@pytest.mark.parametrize(("axis", "amplitude_deg"), [(0, 5.0), (1, 10.0)])
def test_figure_of_merit_of_a_horizontal_offset_in_a_vertical_field(axis, amplitude_deg, recording):
    """Only the tilt towards the offset is seen: |F + d| swings by 2 d sin(amplitude) on each of four headings."""
    left_nT = 10.0
    truth = hold_out(build({}, None, ""), Environment(np.array([0.0, 0.0, -50_000.0])))
    off = exact(offset_nT=left_nT * np.eye(3)[axis], matrix=np.eye(3))
    expected_nT = 4 * 2 * left_nT * np.sin(np.radians(amplitude_deg))
    assert values(off, recording, truth)["figure_of_merit"] == pytest.approx(expected_nT, rel=1e-3, abs=0.01)


def test_claimed_ellipsoid(truth, recording):
    names = ("offset_x_nT", "offset_y_nT", "offset_z_nT")
    off = exact(offset_nT=HARD_NT + np.array([2.0, 0.0, 0.0]), covariance_names=names, covariance=np.eye(3))
    assert values(off, recording, truth)["offset_inside_95"] == 1
    assert values(off, recording, truth)["offset_nees"] == pytest.approx(4.0)
    bold = values(replace(off, covariance=0.25 * np.eye(3)), recording, truth)
    assert (bold["offset_inside_95"], bold["offset_nees"]) == (0, pytest.approx(16.0))
    assert "offset_inside_95" not in values(exact(), recording, truth)


def test_failures_are_counted_and_what_did_not_apply_has_no_figures(truth, recording):
    missing = Calibration(name="vector_least_squares", status=Status("not_applicable", "no attitude"))
    assert {s.name for s in score(missing, recording, truth, False)} == {"failure", "wall_time"}
    assert values(missing, recording, truth)["failure"] == 1
    vague = replace(exact(), status=Status("unobservable", "why"))
    got = values(vague, recording, truth)
    assert (got["failure"], "offset_error" in got) == (1, True)


def test_only_in_sample_figures_are_marked_so(truth, recording):
    scores = score(exact(), recording, truth, False)
    assert [s.name for s in scores if s.in_sample] == ["in_sample_norm_rms"]
    assert scores[0].name == "offset_error"
    assert len({s.name for s in scores}) == len(scores)
    turned = {s.name for s in score(exact(), recording, truth, True) if s.rotation_removed}
    assert turned == {"matrix_error", "holdout_sphere_component_rms", "holdout_level_component_rms", "heading_rms"}


def test_degenerate_fit_wins_in_sample_and_loses_on_the_hold_out(truth, recording):
    strength_nT = np.linalg.norm(FIELD_ENU_NT)
    far = exact(offset_nT=np.array([-1e5 * strength_nT, 0.0, 0.0]), matrix=1e-5 * np.eye(3))
    got, right = values(far, recording, truth), values(exact(), recording, truth)
    assert got["in_sample_norm_rms"] < right["in_sample_norm_rms"] / 2
    assert got["offset_error"] > 1e6
    assert got["holdout_sphere_component_rms"] > 1e3


@pytest.mark.parametrize("name", list(CALIBRATORS))
def test_every_calibrator_can_be_scored(name, truth, recording):
    reference = Reference.of_vector(tuple(FIELD_ENU_NT))
    (candidate,) = select_calibrators([name])
    for s in score(candidate.fit(recording, reference), recording, truth, candidate.attitude_free):
        assert np.isfinite(s.value), s


def test_surroundings_are_the_means_of_the_recording(recording):
    warm = replace(recording, temperature_degC=np.linspace(0, 10, 400), current_A=np.tile([1.0, 2.0], (400, 1)))
    around = Environment.of(warm, FIELD_ENU_NT)
    assert around.time_s == pytest.approx(399 / 20)
    assert around.channels == pytest.approx({"temperature_degC": 5.0, "current_1_A": 1.0, "current_2_A": 2.0})
