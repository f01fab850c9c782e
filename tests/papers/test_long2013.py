"""The reproduction of Long2013: its motion, its errors, attitude from known yaw, and its rows."""

from __future__ import annotations

import numpy as np
import pytest

from papers.long2013.flight_rows import VEHICLES
from papers.long2013.paper import Long2013
from papers.long2013.rows import NOISES_NT, _alignment, _two_step
from papers.long2013.trials import (
    AXES_DEG,
    HARD_IRON_NT,
    OFFSET_NT,
    SCALE,
    SOFT_IRON,
    STRENGTH_NT,
    LongTask,
    algebraic_offset_nT,
    attitude_errors_deg,
    calibration_trial,
    calibration_turns,
    effects,
    measured,
    offset_nT,
    roll_pitch_deg,
    rolling,
    state_of,
)


def printed_matrices():
    alpha, beta, gamma = np.radians(AXES_DEG)
    C_n = np.array(
        [
            [np.sqrt(1 - np.cos(beta) ** 2 - np.cos(gamma) ** 2), np.cos(beta), np.cos(gamma)],
            [0.0, np.cos(alpha), np.sin(alpha)],
            [0.0, 0.0, 1.0],
        ]
    )
    return np.diag(SCALE) @ C_n, np.array(SOFT_IRON)


def test_the_chain_is_the_paper_s_equation():
    state = state_of(calibration_turns()[::37])
    sensor, soft = printed_matrices()
    expected_nT = (state.field_nT @ soft.T + HARD_IRON_NT) @ sensor.T + OFFSET_NT
    np.testing.assert_allclose(measured(state, effects(), 0).mag_nT, expected_nT, atol=1e-6)
    np.testing.assert_allclose(offset_nT(), sensor @ HARD_IRON_NT + OFFSET_NT, atol=1e-6)


def test_share_zero_is_a_perfect_sensor():
    state = state_of(rolling())
    np.testing.assert_allclose(measured(state, effects(0.0), 0).mag_nT, state.field_nT, atol=1e-6)


def test_motion_is_three_turns_and_one_of_all():
    angles_deg = calibration_turns()
    assert angles_deg.shape == (1440, 3)
    assert [np.count_nonzero(np.ptp(angles_deg[k : k + 360], axis=0)) for k in range(0, 1440, 360)] == [1, 1, 1, 3]
    field_nT = state_of(angles_deg).field_nT
    np.testing.assert_allclose(np.linalg.norm(field_nT, axis=1), STRENGTH_NT)
    # nose north and level: 0.71 of the field level, 0.70 of it down, declination to the west, hence to the left
    level = STRENGTH_NT * np.cos(np.radians(44.57))
    np.testing.assert_allclose(
        field_nT[0],
        [level * np.cos(np.radians(4.57)), level * np.sin(np.radians(4.57)), -STRENGTH_NT * np.sin(np.radians(44.57))],
    )


@pytest.mark.parametrize(("yaw", "pitch"), [(90.0, -33.1), (90.0, 20.0), (200.0, 5.0)])
def test_roll_and_pitch_are_found_exactly_without_errors(yaw, pitch):
    angles_deg = np.column_stack((np.full(36, yaw), np.full(36, pitch), np.arange(-175.0, 185.0, 10.0)))
    roll, found = roll_pitch_deg(state_of(angles_deg).field_nT, yaw, pitch)
    np.testing.assert_allclose(found, pitch, atol=1e-9)
    np.testing.assert_allclose((roll - angles_deg[:, 2] + 180) % 360 - 180, 0.0, atol=1e-9)


def test_a_turned_field_is_an_attitude_error_of_that_size():
    """A turn of two degrees about body x, forward, is two degrees of roll and none of pitch."""
    c, s = np.cos(np.radians(2.0)), np.sin(np.radians(2.0))
    turned_nT = state_of(rolling()).field_nT @ np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    errors_deg = attitude_errors_deg(turned_nT)
    np.testing.assert_allclose(np.abs(errors_deg[:, 0]), 2.0, atol=1e-9)
    np.testing.assert_allclose(errors_deg[:, 1], 0.0, atol=1e-9)


def test_one_trial_is_within_the_printed_figures_and_repeats():
    one, other = calibration_trial(LongTask(3, 100.0)), calibration_trial(LongTask(3, 100.0))
    np.testing.assert_array_equal(one.after_nT, other.after_nT)
    assert one.status == "ok"
    assert one.worst_share < 0.02 < 0.3 < np.abs(one.before_nT / STRENGTH_NT - 1).max()
    assert (np.abs(one.corrected_deg).max(axis=0) < [1.0, 2.2]).all()
    assert (np.abs(one.raw_deg).max(axis=0) > [20.0, 10.0]).all()
    assert one.roll_alone == "unobservable"


def test_without_noise_only_alignment_separates_the_two_corrections():
    trial = calibration_trial(LongTask(0, 1e-3))
    assert trial.worst_share < 1e-6
    assert np.abs(trial.corrected_deg).max() < 1e-3
    assert np.abs(trial.unaligned_deg).max() > 1.0
    roll, pitch = np.abs(trial.unaligned_deg).max(axis=0)
    row = _alignment([trial])
    assert row.holds
    assert row.ours.startswith(f"roll {roll:.2f} degrees")
    assert f"pitch {pitch:.2f} degrees" in row.ours


def test_the_algebraic_two_step_is_the_ellipsoid_s_centre():
    """Exact without noise: the centre of an ellipsoid with known axes and offset."""
    rng = np.random.default_rng(5)
    directions = rng.standard_normal((200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    centre_nT = np.array([900.0, -400.0, 250.0])
    field_nT = STRENGTH_NT * directions @ np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]).T
    np.testing.assert_allclose(algebraic_offset_nT(field_nT + centre_nT), centre_nT, rtol=1e-8)


def test_newton_is_as_good_as_the_algebraic_two_step_and_worse_than_the_weighted():
    trials = {100.0: [calibration_trial(LongTask(seed, 100.0)) for seed in range(16)]}
    plain, down, ours = _two_step(trials)
    ratios = [float(row.ours.split("ratio ")[1].split()[0]) for row in (plain, down, ours)]
    assert ratios[0] == pytest.approx(1.0, abs=0.03)
    assert min(ratios[1:]) > ratios[0]
    assert [row.verdict for row in (plain, down, ours)] == ["does not hold"] * 3
    assert all(row.judged.tolerance and row.judged.reason for row in (plain, down, ours))


def test_rows_and_pictures():
    told = []
    findings = Long2013(seeds=3).run(progress=lambda done, total: told.append((done, total)))
    pieces = 3 * len(NOISES_NT) + len(VEHICLES)
    assert told[-1] == (pieces, pieces)
    printed = {row.paper: row for row in findings.rows if "flown" not in row.what}
    for figure in ("within 2 %", "1 degree", "2.2 degrees"):
        assert printed[figure].holds
    assert set(findings.figures) == {"strength", "attitude", "noise"}
    for draw in findings.figures.values():
        assert draw().axes
