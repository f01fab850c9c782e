"""Verdicts on axes in words: what is said with each set of instruments, and what mends it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.axes_alarms import Conditions, simulated
from calib import Reference
from validation.axes.estimate import axes_of, field_down
from validation.axes.wording import axes_verdict

LOG = simulated(np.random.default_rng(4), Conditions())
PROPER = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
MIRRORED = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])


@pytest.mark.parametrize(
    ("taken", "instruments", "kind", "told"),
    [
        (np.eye(3), (), "alone", "alone does not tell"),
        (np.eye(3), ("gyro",), "agree", "agree with the gyro"),
        (np.eye(3), ("gyro", "accel", "q"), "agree", "agree with the gyro, accelerometer and attitude"),
        (PROPER, ("gyro",), "turned", "--axes y,x,-z, or if left-handed, an axis mirrored, --axes -y,-x,z"),
        (PROPER, ("gyro", "accel"), "turned", "--axes y,x,-z (field downward"),
        (PROPER, ("gyro", "q"), "turned", "turned against the gyro and attitude: --axes y,x,-z"),
        (PROPER, ("q",), "turned", "or its quaternion is of another body frame or order"),
        (MIRRORED, ("gyro", "accel"), "left_handed", "no turn makes it right"),
        (MIRRORED, ("gyro", "accel"), "left_handed", "--axes y,x,z"),
        (MIRRORED, ("gyro",), "turned", "--axes -y,-x,-z, or if left-handed, an axis mirrored, --axes y,x,z"),
    ],
)
def test_the_verdict(taken: np.ndarray, instruments: tuple[str, ...], kind: str, told: str) -> None:
    found = axes_verdict(LOG.axes(taken, instruments))
    assert found.kind == kind
    assert told in found.text


def test_a_field_known_to_point_down() -> None:
    """Proper axes of a log from the south look mirrored until the hemisphere is known."""
    south = axes_of(LOG.time_s, LOG.mag_nT @ PROPER, gyro=LOG.gyro, accel=-LOG.accel)
    assert axes_verdict(south).kind == "left_handed"
    known = replace(south, down=False)
    assert axes_verdict(known).kind == "turned"
    assert "south of" not in axes_verdict(known).text
    assert axes_verdict(LOG.axes(np.eye(3), ("gyro", "accel"), down=False)).kind == "reversed"


def test_a_gyro_of_opposite_sense_is_told() -> None:
    found = axes_verdict(axes_of(LOG.time_s, LOG.mag_nT, gyro=-LOG.gyro))
    assert found.kind == "gyro_reversed"
    assert "scale=-1" in found.text


def test_the_vertical_of_a_reference() -> None:
    assert field_down(None) is None
    assert field_down(Reference(48_000.0)) is None
    assert field_down(Reference.of_vector((0.0, 20_000.0, -40_000.0))) is True
    assert field_down(Reference.of_vector((0.0, 20_000.0, 40_000.0))) is False
    assert field_down(Reference.of_vector((0.0, 30_000.0, 1000.0))) is None
