"""The strength of a log without a place: the median with the calibration that was in force."""

from __future__ import annotations

import numpy as np
import pytest

from recordings import Origin
from recordings.applied import AppliedCalibration
from recordings.reading import listening
from scenarios.arrays import Array
from validation.calibrating.reference import told_field

OFFSET_NT = np.array([2500.0, 20_000.0, -13_000.0])
MATRIX = np.diag([1.02, 0.99, 1.01])
STRENGTH_NT = 48_180.0


def _measured() -> Array:
    ways = np.random.default_rng(1).normal(size=(500, 3))
    true_nT = STRENGTH_NT * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    return true_nT @ np.linalg.inv(MATRIX).T + OFFSET_NT


def _origin(offset_nT: Array, matrix: Array) -> Origin:
    return Origin(applied=AppliedCalibration("px4", 0, offset_nT, matrix, {}))


def test_the_calibration_in_force_gives_the_strength_and_says_so() -> None:
    told: list[str] = []
    with listening(told.append):
        strength, vector = told_field(None, None, _origin(OFFSET_NT, MATRIX), _measured())
    assert strength == pytest.approx(STRENGTH_NT)
    assert vector is None
    assert any("48180 nT" in line and "in force" in line for line in told)


@pytest.mark.parametrize(
    ("offset_nT", "matrix"),
    [(np.zeros(3), np.eye(3)), (OFFSET_NT, 10 * MATRIX)],
    ids=["none in force", "not the Earth's field"],
)
def test_no_strength_from_a_calibration_that_tells_none(offset_nT: Array, matrix: Array) -> None:
    assert told_field(None, None, _origin(offset_nT, matrix), _measured()) == (None, None)


def test_what_is_stated_comes_first() -> None:
    assert told_field(50_000.0, None, _origin(OFFSET_NT, MATRIX), _measured()) == (50_000.0, None)
