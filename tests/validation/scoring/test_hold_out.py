"""The survey line and its buried dipole, against what is written on paper."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from validation.scoring.hold_out import Environment, HoldOutMotion, dipole_enu_nT, hold_out, survey_line
from validation.scoring.scores import heading_error_rad

FIELD_ENU_NT = np.array([-4000.0, 20000.0, -45000.0])
BURIED_M = np.array([5.0, 8.0, -20.0])


def textbook(pos_m: np.ndarray) -> np.ndarray:
    """3 (u . r) r / r^5 - u / r^3 of a body magnetised along the Earth's field u."""
    along = FIELD_ENU_NT / np.linalg.norm(FIELD_ENU_NT)
    fields = []
    for r in pos_m - BURIED_M:
        size = np.sqrt(r[0] ** 2 + r[1] ** 2 + r[2] ** 2)
        fields.append(3 * np.dot(along, r) * r / size**5 - along / size**3)
    return np.array(fields)


def test_line_leads_east_and_back_in_steps_of_half_a_metre() -> None:
    pos_m, attitudes = survey_line()
    there, back = np.split(pos_m[:, 0], 2)
    np.testing.assert_allclose(there, np.linspace(-60.0, 60.0, 241))
    np.testing.assert_allclose(back, there[::-1])
    np.testing.assert_array_equal(pos_m[:, 1:], 0.0)
    forward = attitudes.as_matrix()[:, :, 0]
    assert forward[:241, 0].min() > np.cos(np.radians(4.3))  # ahead within three degrees of roll and pitch
    assert forward[241:, 0].max() < -np.cos(np.radians(4.3))


def test_dipole_is_the_textbooks_with_a_peak_of_100_nT() -> None:
    pos_m = survey_line()[0]
    field_nT, expected = dipole_enu_nT(pos_m, FIELD_ENU_NT), textbook(pos_m)
    peak = np.linalg.norm(expected, axis=1).max()
    np.testing.assert_allclose(field_nT, 100.0 / peak * expected, rtol=1e-9, atol=1e-9)


def test_anomaly_is_the_dipoles_part_along_the_earths_field() -> None:
    """|F + b| - |F| = b . F / |F| to first order; the next is below b^2 / (2 F) = 0.1 nT."""
    truth = hold_out((), Environment(FIELD_ENU_NT))
    pos_m = survey_line()[0]
    along = dipole_enu_nT(pos_m, FIELD_ENU_NT) @ FIELD_ENU_NT / np.linalg.norm(FIELD_ENU_NT)
    np.testing.assert_allclose(truth.line_anomaly_nT, along, atol=0.11)
    nearest = np.abs(pos_m[np.argmax(along), 0] - BURIED_M[0])
    assert nearest < 20.0


def test_heading_error_is_the_angle_by_which_the_field_was_turned() -> None:
    """About the true vertical, of any size and sign, in any attitude; tilting the field up or down changes nothing."""
    rng = np.random.default_rng(4)
    turns = np.radians(np.linspace(-179.0, 179.0, 61))
    R_wb = Rotation.random(len(turns), rng=rng).as_matrix()
    steeper = np.tile(FIELD_ENU_NT, (len(turns), 1)) + np.outer(rng.normal(size=len(turns)), [0.0, 0.0, 1e4])
    turned = Rotation.from_rotvec(np.outer(turns, [0.0, 0.0, -1.0])).apply(steeper)
    true_nT, turned_nT = (np.einsum("nij,ni->nj", R_wb, world) for world in (0 * turned + FIELD_ENU_NT, turned))
    pairs = HoldOutMotion(R_wb, true_nT, np.zeros_like(true_nT))
    assert heading_error_rad(turned_nT, pairs) == pytest.approx(turns, abs=1e-12)
