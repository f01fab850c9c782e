"""Iron from strength and dip, beside a prior: a turn against the vertical shows too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.policy import STANDARD
from diagnosis.problem.iron_by_dip import ByDip, fit_iron_by_dip
from scenarios.arrays import Array

FIELD_ENU_NT = np.array([2_000.0, 20_000.0, -43_000.0])
STRENGTH_NT = float(np.linalg.norm(FIELD_ENU_NT))
DIP_RAD = float(np.arctan2(43_000.0, np.hypot(2_000.0, 20_000.0)))
NOISE_NT, BLOCK, SAMPLES = 20.0, 50, 4000
SIT = Rotation.from_euler("ZYX", [2.0, -1.5, 1.0], degrees=True).as_matrix()
MATRIX = np.array([[1.05, 0.02, -0.01], [0.02, 0.97, 0.03], [-0.01, 0.03, 1.02]]) @ SIT
OFFSET_NT = np.array([800.0, -1500.0, 2500.0])


def _measured(tilt_deg: float, noise_nT: float = NOISE_NT) -> tuple[Array, Array]:
    """What a sensor that sits turned, with iron, measures at random attitudes, and down in the body frame."""
    rng = np.random.default_rng(0)
    angles = np.column_stack([rng.uniform(0, 360, SAMPLES), *(tilt_deg * rng.uniform(-1, 1, (2, SAMPLES)))])
    to_body = Rotation.from_euler("ZYX", angles, degrees=True).inv()
    field_nT, down = to_body.apply(FIELD_ENU_NT), to_body.apply([0.0, 0.0, -1.0])
    measured = field_nT @ np.linalg.inv(MATRIX).T + OFFSET_NT
    return measured + noise_nT * rng.normal(size=measured.shape), down


@pytest.mark.parametrize("wrong_deg", [0.0, 0.4])
def test_the_iron_is_the_true_one_with_the_turn_of_the_sensor(wrong_deg: float) -> None:
    """The strength alone does not see how the sensor sits; a constant error of the given dip bends nothing."""
    measured, down = _measured(60.0)
    given = np.full(SAMPLES, DIP_RAD + np.radians(wrong_deg))
    iron = fit_iron_by_dip(measured, np.full(SAMPLES, STRENGTH_NT), down, given, BLOCK, STANDARD)
    assert np.allclose(iron.matrix, MATRIX, atol=3e-4)
    assert np.allclose(iron.offset_nT, OFFSET_NT, atol=8.0)


def test_nearly_level_the_prior_stands_for_what_is_not_shown() -> None:
    measured, down = _measured(0.5)
    given = np.full(SAMPLES, DIP_RAD)
    iron = fit_iron_by_dip(measured, np.full(SAMPLES, STRENGTH_NT), down, given, BLOCK, STANDARD)
    size = np.linalg.svd(iron.matrix)[1]
    assert 0.5 < size.min() < size.max() < 1.5


def test_counts_are_brought_to_the_unit_of_the_field() -> None:
    measured, down = _measured(60.0)
    of = (np.full(SAMPLES, STRENGTH_NT), down, np.full(SAMPLES, DIP_RAD), BLOCK, STANDARD)
    counts, same = (fit_iron_by_dip(values, *of) for values in (measured / 100, measured))
    assert np.allclose(counts.matrix / 100, same.matrix, rtol=1e-3, atol=1e-4)


def test_slopes_are_those_of_small_differences() -> None:
    rng = np.random.default_rng(4)
    y, down = rng.normal(size=(20, 3)), rng.normal(size=(20, 3))
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    task = ByDip(y, rng.uniform(0.9, 1.1, 20), down, rng.uniform(-1, 1, 20), STANDARD)
    theta = task.prior_mean + 0.1 * rng.normal(size=13)
    differences = [(task.residual(theta + one) - task.residual(theta - one)) / 2e-6 for one in 1e-6 * np.eye(13)]
    assert np.allclose(task.jacobian(theta), np.stack(differences, axis=2), atol=1e-7)
