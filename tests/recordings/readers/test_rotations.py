"""The autopilots' numbered mountings, against turns written out axis by axis and published matrices."""

from __future__ import annotations

import numpy as np
import pytest

from recordings.readers.rotations import CUSTOM, ROTATIONS, board_rotation, euler_rotation

NOSE, RIGHT, DOWN = np.eye(3)
SOLO_LEG = np.array(
    [
        [0.14303897231223747, 0.36877648650320383, -0.91844638134308709],
        [-0.33213277779664741, -0.85628942146641884, -0.39554550256296523],
        [-0.93232380121551217, 0.36162457008209242, 0.0],
    ]
)
"""Number 38 as ArduPilot's Vector3::rotate multiplies it."""
TURNS = {
    2: (RIGHT, -NOSE, DOWN),
    4: (-NOSE, -RIGHT, DOWN),
    8: (NOSE, -RIGHT, -DOWN),
    12: (-NOSE, RIGHT, -DOWN),
    16: (NOSE, DOWN, -RIGHT),
    24: (-DOWN, RIGHT, NOSE),
    28: (-DOWN, NOSE, -RIGHT),
    36: (-RIGHT, -DOWN, NOSE),
    37: (-RIGHT, DOWN, -NOSE),
}
"""Where a sensor's x, y and z axes point, by number, thought through by hand."""


@pytest.mark.parametrize("autopilot", ROTATIONS)
@pytest.mark.parametrize("number", TURNS)
def test_axes_point_where_the_name_says(autopilot: str, number: int) -> None:
    np.testing.assert_array_equal(board_rotation(number, autopilot), np.column_stack(TURNS[number]))


@pytest.mark.parametrize("autopilot", ROTATIONS)
def test_every_mounting_is_a_rotation_and_only_two_pairs_agree(autopilot: str) -> None:
    found = {number: board_rotation(number, autopilot) for number in ROTATIONS[autopilot]}
    for number, matrix in found.items():
        np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-15, err_msg=str(number))
        assert np.linalg.det(matrix) == pytest.approx(1.0)
    same = [(a, b) for a in found for b in found if a < b and np.allclose(found[a], found[b])]
    assert same == [(10, 27), (14, 26)]


def test_the_autopilots_differ_at_38_and_beyond_40() -> None:
    np.testing.assert_allclose(board_rotation(38, "ardupilot"), SOLO_LEG, atol=1e-15)
    assert np.abs(board_rotation(38, "px4") - SOLO_LEG).max() > 0.005
    assert set(ROTATIONS["ardupilot"]) == set(range(44))
    assert set(ROTATIONS["px4"]) == set(range(41))


@pytest.mark.parametrize("number", [-1, 44, *CUSTOM])
def test_a_number_without_angles_is_refused(number: int) -> None:
    with pytest.raises(ValueError, match="has no mounting of number"):
        board_rotation(number, "ardupilot")


def test_angles_are_applied_roll_first() -> None:
    roll, pitch, yaw = (euler_rotation(*angles) for angles in ((20, 0, 0), (0, 31, 0), (0, 0, 72)))
    np.testing.assert_allclose(euler_rotation(20, 31, 72), yaw @ pitch @ roll, atol=1e-15)
