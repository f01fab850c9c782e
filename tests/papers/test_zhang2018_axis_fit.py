"""The rotation-axis fit that [Zhang2018] refers to: normals of turns, the rotation, and what one axis leaves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from papers.zhang2018.axis_fit import CIRCLES, TURNS, AxisErrors, axis_rows, axis_trial, normal, rotation, turns
from papers.zhang2018.trials import NOISE_NT, PRINTED_SOFT, spiral, strength_nT

LEANING = Rotation.from_rotvec([0.03, -0.02, 0.05]).as_matrix()


def test_each_turn_keeps_the_field_along_its_axis_and_turns_the_rest() -> None:
    field_nT = turns()
    for k, turn in enumerate(field_nT):
        assert np.ptp(turn[:, k]) < 1e-6
        assert np.ptp(turn[:, (k + 1) % 3]) > 0.1 * strength_nT(spiral(False))
        np.testing.assert_allclose(np.linalg.norm(turn, axis=1), strength_nT(spiral(False)))


def test_normals_of_three_turns_give_the_rotation() -> None:
    seen = turns() @ LEANING
    normals = np.array([normal(turn, axis) for turn, axis in zip(seen, np.eye(3), strict=True)])
    np.testing.assert_allclose(normals, LEANING, atol=1e-9)
    np.testing.assert_allclose(rotation(normals, np.eye(3)), LEANING, atol=1e-9)


def test_one_axis_gives_the_shortest_turn_and_leaves_the_turn_about_itself() -> None:
    up = np.array([[0.0, 0.0, 1.0]])
    about = Rotation.from_euler("z", 20.0, degrees=True).as_matrix()
    np.testing.assert_allclose(rotation(up @ about, up), np.eye(3), atol=1e-12)
    lean = Rotation.from_euler("x", 3.0, degrees=True)
    found = rotation(up @ lean.as_matrix(), up)
    np.testing.assert_allclose(found, lean.as_matrix(), atol=1e-12)


@pytest.fixture(scope="module")
def trials() -> list[AxisErrors]:
    return [axis_trial(seed) for seed in (0, 1)]


def test_three_turns_leave_the_noise_and_the_swarm_alone_leaves_the_rotation(trials: list[AxisErrors]) -> None:
    """The rotation is that of eq. 7 by QR: A_soft^-1 = Q R."""
    Q = np.linalg.qr(np.linalg.inv(PRINTED_SOFT))[0]
    Q = Q * np.sign(np.diag(Q))
    angle_deg = np.degrees(Rotation.from_matrix(Q).magnitude())
    for trial in trials:
        assert trial.fitted_nT[TURNS] == pytest.approx(NOISE_NT, rel=0.2)
        assert trial.alone_nT[TURNS] > 100 * NOISE_NT
        assert trial.angle_deg[TURNS] == pytest.approx(angle_deg, abs=0.01)
        assert trial.offset_nT[TURNS] < 3 * NOISE_NT


def test_level_circles_leave_the_error_as_large_as_before(trials: list[AxisErrors]) -> None:
    for trial in trials:
        assert trial.fitted_nT[CIRCLES] > 0.8 * trial.alone_nT[CIRCLES] > 50.0
        assert trial.offset_nT[CIRCLES] > 50.0
    rows = axis_rows(trials)
    assert [row.verdict for row in rows] == ["not comparable"] * 2
    assert all(TURNS in row.what or CIRCLES in row.what for row in rows)
