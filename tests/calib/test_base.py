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


@pytest.mark.parametrize("act", ["singular", "divides", "overflows", "nan"])
def test_numerical_failure_becomes_a_status(act, standard):
    result = Scripted(act).fit(standard.recording("full", None, n=50), standard.REFERENCE)
    assert result.status.kind == "not_converged"
    assert result.status.reason
    assert np.isfinite(result.offset_nT).all()


def test_a_calibrator_cannot_write_to_the_recording(standard):
    with pytest.raises(ValueError, match="read-only"):
        Scripted("writes").fit(standard.recording("full", None, n=50), standard.REFERENCE)


def test_claimed_deviation_above_the_limit_is_unobservable_and_names_the_direction(standard):
    recording = standard.recording("full", None, n=50)
    assert Scripted("tight").fit(recording, standard.REFERENCE).status.kind == "ok"
    status = Scripted("loose").fit(recording, standard.REFERENCE).status
    assert status.kind == "unobservable"
    assert "body y" in status.reason
    assert "yaw and roll" in status.reason


def test_name_time_and_default_seed_are_the_base_s(standard):
    recording = standard.recording("full", None, n=50)
    one, other = (Scripted().fit(recording, standard.REFERENCE) for _ in range(2))
    assert one.name == "scripted"
    assert one.wall_s > 0
    np.testing.assert_array_equal(one.offset_nT, other.offset_nT)
    third = Scripted().fit(recording, standard.REFERENCE, np.random.default_rng(1))
    assert third.offset_nT[0] != one.offset_nT[0]


@pytest.mark.parametrize("need", list(NEEDS))
def test_every_need_says_what_to_record(need, standard):
    bare = replace(standard.recording("full", None, n=50), gyro_rad_s=None, att_q=None)
    wanting = type("Wanting", (Scripted,), {"needs": (need,)})
    status = wanting().fit(bare, Reference(5e4)).status
    assert status.kind == "not_applicable"
    assert NEEDS[need][1] in status.reason
