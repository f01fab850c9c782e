"""What the base does with calibrators that fail or misbehave."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from calib import Reference
from calib.base import NEEDS, Calibrator
from calib.result import OFFSET_NAMES, Calibration, Status


@dataclass(frozen=True)
class Scripted(Calibrator):
    """A calibrator that does as it is told."""

    name: ClassVar[str] = "scripted"
    summary: ClassVar[str] = "for tests"
    act: str = "fine"

    def _solve(self, recording, reference, rng):
        acts = {
            "writes": lambda: recording.mag_nT.__setitem__(0, 0.0),
            "singular": lambda: np.linalg.inv(np.zeros((3, 3))),
            "divides": lambda: np.array([1.0]) / np.array([0.0]),
            "overflows": lambda: np.array([1e300]) * np.array([1e300]),
        }
        if self.act in acts:
            acts[self.act]()
        offset_nT = np.full(3, np.nan if self.act == "nan" else float(rng.normal()))
        loose = {"loose": 1e6, "tight": 1.0}.get(self.act)
        covariance = None if loose is None else np.diag([1.0, loose, 1.0]) * 1e3
        return Calibration(
            name="other name",
            status=Status("ok"),
            offset_nT=offset_nT,
            covariance=covariance,
            covariance_names=OFFSET_NAMES,
        )


def perfect(standard, n=50):
    """A sensor without any error."""
    recording = standard.recording("full", None, n=n, soft=np.eye(3))
    return replace(recording, mag_nT=recording.mag_nT - standard.HARD_NT)


@pytest.mark.parametrize("act", ["singular", "divides", "overflows", "nan"])
def test_numerical_failure_becomes_a_status(act, standard):
    result = Scripted(act).fit(perfect(standard), standard.REFERENCE)
    assert result.status.kind == "not_converged"
    assert result.status.reason
    assert np.isfinite(result.offset_nT).all()


def test_a_calibrator_cannot_write_to_the_recording(standard):
    with pytest.raises(ValueError, match="read-only"):
        Scripted("writes").fit(perfect(standard), standard.REFERENCE)


def test_claimed_deviation_above_the_limit_is_unobservable_and_names_the_direction(standard):
    recording = perfect(standard)
    assert Scripted("tight").fit(recording, standard.REFERENCE).status.kind == "ok"
    status = Scripted("loose").fit(recording, standard.REFERENCE).status
    assert status.kind == "unobservable"
    assert "body y" in status.reason
    assert "yaw and roll" in status.reason


def test_name_time_and_default_seed_are_the_base_s(standard):
    recording = perfect(standard)
    one, other = (Scripted().fit(recording, standard.REFERENCE) for _ in range(2))
    assert one.name == "scripted"
    assert one.wall_s > 0
    np.testing.assert_array_equal(one.offset_nT, other.offset_nT)
    third = Scripted().fit(recording, standard.REFERENCE, np.random.default_rng(1))
    assert third.offset_nT[0] != one.offset_nT[0]


@pytest.mark.parametrize("need", list(NEEDS))
def test_every_need_says_what_to_record(need, standard):
    bare = replace(perfect(standard), gyro_rad_s=None, att_q=None)
    wanting = type("Wanting", (Scripted,), {"needs": (need,)})
    status = wanting().fit(bare, Reference(5e4)).status
    assert status.kind == "not_applicable"
    assert NEEDS[need][1] in status.reason


def test_noise_that_hides_the_motion_leaves_no_estimate(standard):
    """Without a word of the method's own noise, the noise is what the fit leaves."""
    recording = perfect(standard)
    noise_nT = np.random.default_rng(0).normal(0.0, 2000.0, recording.mag_nT.shape)
    result = Scripted("tight").fit(replace(recording, mag_nT=recording.mag_nT + noise_nT), standard.REFERENCE)
    assert result.status.kind == "unobservable"
    assert "lie in a plane" in result.status.reason
    np.testing.assert_array_equal(result.offset_nT, 0.0)


def test_a_turn_about_one_axis_is_for_those_who_ask_for_it(standard):
    level = standard.level_turns(600, None)
    assert "lie in a plane" in Scripted().fit(level, standard.REFERENCE).status.reason
    one_axis = type("OneAxis", (Scripted,), {"one_axis": True})
    assert "lie in a plane" not in one_axis().fit(level, standard.REFERENCE).status.reason


def test_attitude_that_moves_by_no_more_than_its_error_is_no_motion(standard):
    vector = type("Vector", (Scripted,), {"needs": ("attitude", "field_vector")})
    recording = perfect(standard, 600)
    assert vector().fit(recording, standard.REFERENCE).status.kind == "ok"
    status = vector(attitude_std_rad=0.3).fit(recording, standard.REFERENCE).status
    assert status.kind == "unobservable"
    assert "degrees rms" in status.reason


@pytest.mark.parametrize("sequential", [False, True])
def test_a_sequential_claim_is_left_alone(sequential, standard):
    method = type("Maybe", (Scripted,), {"sequential": sequential})
    recording = perfect(standard, 1200)
    drift_nT = np.outer(recording.time_s, [3.0, -2.0, 2.0])
    result = method("tight").fit(replace(recording, mag_nT=recording.mag_nT + drift_nT), standard.REFERENCE)
    assert ("covariance_inflation" in result.parameters) is not sequential
