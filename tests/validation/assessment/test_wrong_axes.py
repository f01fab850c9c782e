"""A heading is not answered for while the magnetometer's axes are not the vehicle's."""

from __future__ import annotations

import pytest

import magbench
from tests.conftest import ROOT

CASES = ROOT / "tests" / "recordings" / "cases"


@pytest.mark.parametrize("name", ["imu_swapped_proper.csv", "imu_swapped_lefthanded.csv"])
def test_wrong_axes_are_neither_good_nor_within_a_tolerance(name: str) -> None:
    found = magbench.calibrate(CASES / name, 48_000, with_=["ellipsoid"], tolerance_deg=20.0).assessment
    assert found.calibrations["ellipsoid"].quality == "bad"
    assert found.calibrations["ellipsoid"].trust.word == "low"
    assert found.tolerance is not None
    assert found.tolerance.answer != "yes"
    assert found.tolerance.wrong_axes


def test_mended_axes_are_answered_for() -> None:
    mended, log = magbench.Reading(axes="y,x,-z"), CASES / "imu_swapped_proper.csv"
    found = magbench.calibrate(log, 48_000, with_=["ellipsoid"], reading=mended, tolerance_deg=20.0).assessment
    assert found.calibrations["ellipsoid"].wrong_axes == ""
    assert found.tolerance is not None
    assert found.tolerance.answer == "yes"
