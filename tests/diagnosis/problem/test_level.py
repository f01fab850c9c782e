"""Down by roll and pitch: the dip of a field, where it grows, and what is compared beside the strength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import channels
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose, refit_iron
from diagnosis.problem.known import FieldTrack, Known, Level
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import dip_rad, upright
from scenarios.arrays import Array
from sim.effects.currents import MotorCurrent
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, STRENGTH_NT, recording, without_attitude

GIVEN = recording()
CURRENT = {"motor_current": {"gain_nT_A": [3.0, -1.0, 2.0]}}


def _R_wb(heading_deg: float = 0.0) -> Array:
    """The attitude of the synthetic motion with its heading off by an angle."""
    assert GIVEN.att_q is not None
    turned = Rotation.from_euler("Z", heading_deg, degrees=True) * Rotation.from_quat(GIVEN.att_q[:, [1, 2, 3, 0]])
    return np.asarray(turned.as_matrix())


def _posed(heading_deg: float = 0.0, **made: object) -> LinearProblem:
    level = Level.of(_R_wb(heading_deg), FIELD_ENU_NT, STANDARD)
    given = without_attitude(recording(**made) if made else GIVEN)  # type: ignore[arg-type]
    return pose(given, Known(FIELD_ENU_NT, STRENGTH_NT, level=level))


def test_the_dip_is_the_angle_below_the_level_whatever_the_heading() -> None:
    down = -_R_wb(40.0)[:, 2]
    field = np.einsum("nji,j->ni", _R_wb(), FIELD_ENU_NT)
    assert np.degrees(dip_rad(field, down)) == pytest.approx(np.degrees(np.arctan2(43.0, np.hypot(1.0, 20.0))))


def test_upright_is_where_the_dip_grows() -> None:
    rng = np.random.default_rng(0)
    u, down, step = (rng.normal(size=(30, 3)) for _ in range(3))
    u, down = (one / np.linalg.norm(one, axis=1, keepdims=True) for one in (u, down))
    grown = (dip_rad(u + 1e-6 * step, down) - dip_rad(u - 1e-6 * step, down)) / 2e-6
    assert grown == pytest.approx(np.einsum("ni,ni->n", upright(u, down), step), abs=1e-6)


def test_no_level_where_the_field_stands_upright() -> None:
    assert Level.of(_R_wb(), np.array([0.0, 900.0, -45_000.0]), STANDARD) is None


def test_strength_and_dip_are_compared_and_the_heading_does_not_matter() -> None:
    one, turned = _posed(), _posed(heading_deg=70.0)
    assert one.compared == "strength+dip"
    assert one.target == pytest.approx(turned.target, abs=1e-5)
    assert one.sigma_nT == pytest.approx([NOISE_NT, NOISE_NT], rel=0.05)
    assert (Baseline.of(one).residual() ** 2).mean(axis=0) == pytest.approx([1.0, 1.0], abs=0.1)
    assert {"pitch", "roll"} <= dict(channels(one)).keys()
    assert "heading" not in dict(channels(one))


def test_a_current_comes_out_at_its_size_with_a_smaller_error_than_by_the_strength_alone() -> None:
    given = without_attitude(recording(hidden=CURRENT))
    alone, both = pose(given, Known(None, STRENGTH_NT)), _posed(hidden=CURRENT)
    left = []
    for posed in (alone, both):
        columns = Candidate(MotorCurrent, (("motor", 1),)).columns(posed)
        baseline = Baseline.of(posed)
        left.append(baseline.evidence_of(columns))
    assert left[1] > 1.5 * left[0] > 50


def test_a_disturbance_that_was_taken_out_goes_in_again() -> None:
    """About iron that was fitted with a part out, what the part makes is in the target as its columns say."""
    before = _posed(hidden=CURRENT)
    part = np.outer(np.sin(np.arange(len(GIVEN)) / 40), [3.0, -5.0, 4.0])
    after = refit_iron(before, part)
    moved = (after.target - before.target).reshape(-1, 1)
    both = np.concatenate([before.base, after.base], axis=2).reshape(len(moved), -1)
    left = moved - both @ np.linalg.lstsq(both, moved, rcond=1e-10)[0]
    assert np.sqrt((left**2).mean()) < 0.02
    assert after.compared == "strength+dip"


def test_along_a_track_the_dip_changes_as_the_field_does() -> None:
    change = np.outer(np.linspace(0, 1, len(GIVEN)), [0.0, 500.0, 300.0])
    level = Level.of(_R_wb(), FIELD_ENU_NT, STANDARD, FieldTrack(FIELD_ENU_NT, change))
    assert level is not None
    dip = level.dip_rad
    assert dip[0] == pytest.approx(np.arctan2(43_000.0, np.hypot(1_000.0, 20_000.0)))
    assert dip[-1] == pytest.approx(np.arctan2(42_700.0, np.hypot(1_000.0, 20_500.0)))
    assert len(Known(None, STRENGTH_NT, level=level).at(np.arange(len(GIVEN)) < 100).level.down) == 100


def test_samples_left_out_are_left_out_of_both() -> None:
    posed = _posed().without(np.arange(len(GIVEN)) % 7 == 0)
    gone = posed.usable == 0
    assert not posed.target[gone].any()
    assert not posed.base[gone].any()
    assert replace(posed, usable=np.ones(len(GIVEN))).target[~gone].all()
