"""Iron from the strength alone, and from strength and dip, beside a prior."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from diagnosis.policy import STANDARD
from diagnosis.problem.known import Level
from diagnosis.problem.strength import deviations, fit_iron, unit_of
from diagnosis.problem.vector import robust_fit
from scenarios.arrays import Array

FIELD_NT, NOISE_NT, TIME_S = 50_000.0, 20.0, np.arange(4000) / 10
KNOWN_NT = np.full(4000, FIELD_NT)
MATRIX = np.array([[1.05, 0.02, -0.01], [0.02, 0.97, 0.03], [-0.01, 0.03, 1.02]])
OFFSET_NT = np.array([800.0, -1500.0, 2500.0])


def _measured(rng: np.random.Generator, least_up: float = -1.0, most_up: float = 1.0) -> Array:
    """Directions with their vertical part between two limits, as an instrument with iron measures them."""
    up, heading = rng.uniform(least_up, most_up, 4000), np.cumsum(rng.normal(0, 0.05, 4000))
    level = np.sqrt(1 - up**2)
    field = FIELD_NT * np.column_stack([level * np.cos(heading), level * np.sin(heading), up])
    return np.asarray(field @ np.linalg.inv(MATRIX) + OFFSET_NT + NOISE_NT * rng.normal(size=field.shape))


def test_over_the_whole_sphere_the_iron_is_the_true_one() -> None:
    iron = fit_iron(_measured(np.random.default_rng(0)), KNOWN_NT, TIME_S, STANDARD)
    assert np.allclose(iron.matrix, MATRIX, atol=2e-4)
    assert np.allclose(iron.offset_nT, OFFSET_NT, atol=5.0)


def test_far_values_do_not_bend_it() -> None:
    rng = np.random.default_rng(1)
    measured = _measured(rng)
    measured[rng.random(len(measured)) < 0.02] += 30_000.0
    iron = fit_iron(measured, KNOWN_NT, TIME_S, STANDARD)
    assert np.allclose(iron.matrix, MATRIX, atol=5e-4)


@pytest.mark.parametrize("wander_nT", [0.0, 300.0])
def test_in_a_plane_the_prior_stands_for_what_the_motion_does_not_show(wander_nT: float) -> None:
    rng = np.random.default_rng(2)
    walk = gaussian_filter1d(rng.normal(size=(4000, 3)), 200, axis=0)
    iron = fit_iron(_measured(rng, -0.9, -0.899) + wander_nT * walk / walk.std(), KNOWN_NT, TIME_S, STANDARD)
    size = np.linalg.svd(iron.matrix)[1]
    assert 0.5 < size.min() < size.max() < 1.5
    assert np.linalg.norm(iron.offset_nT) < FIELD_NT


def test_a_strong_disturbance_in_a_plane_does_not_carry_the_offset_away() -> None:
    rng = np.random.default_rng(5)
    switched = 3000.0 * np.sign(np.sin(np.arange(4000) / 150.0))[:, None] * [0.6, -0.3, 0.74]
    iron = fit_iron(_measured(rng, -0.9, -0.899) + switched, KNOWN_NT, TIME_S, STANDARD)
    assert np.linalg.norm(iron.offset_nT) < 2 * FIELD_NT


def test_measurements_in_another_unit_are_brought_to_the_field_s() -> None:
    measured = _measured(np.random.default_rng(3))
    counts, same = (fit_iron(values, KNOWN_NT, TIME_S, STANDARD) for values in (measured / 100, measured))
    assert np.allclose(counts.matrix / 100, same.matrix, rtol=1e-3, atol=1e-4)


def test_what_one_attitude_shows_is_shared_between_matrix_and_offset_as_little_as_either_is_expected() -> None:
    """A tenth too much: least squares of a / 0.25 and o / 0.5, in strengths, with ``(1 + a) (1.1 - o) = 1``."""
    a = np.linspace(-0.1, 0.0, 10_001)
    expected = a[np.argmin((a / 0.25) ** 2 + ((1.1 - 1 / (1 + a)) / 0.5) ** 2)]
    measured = np.tile([1.1 * FIELD_NT, 0.0, 0.0], (100, 1))
    iron = fit_iron(measured, np.full(100, FIELD_NT), TIME_S[:100], STANDARD)
    assert iron.matrix[0, 0] - 1 == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(("times", "unit"), [(1.8, 1.0), (2.2, 1 / 2.2), (0.55, 1.0), (0.45, 1 / 0.45)])
def test_what_is_off_by_more_than_a_factor_of_two_is_in_another_unit(times: float, unit: float) -> None:
    measured = times * np.array([[3e4, 0.0, 4e4]])
    assert unit_of(measured, np.array([5e4]), STANDARD)[0] == pytest.approx(unit)


FIELD_ENU_NT = np.array([2_000.0, 20_000.0, -43_000.0])
STRENGTH_NT = float(np.linalg.norm(FIELD_ENU_NT))
DIP_RAD = float(np.arctan2(43_000.0, np.hypot(2_000.0, 20_000.0)))
SAMPLES = len(KNOWN_NT)
SIT = Rotation.from_euler("ZYX", [2.0, -1.5, 1.0], degrees=True).as_matrix()
TURNED = MATRIX @ SIT


def _measured_with_dip(tilt_deg: float, noise_nT: float = NOISE_NT) -> tuple[Array, Array]:
    """What a sensor that sits turned, with iron, measures at random attitudes, and down in the body frame."""
    rng = np.random.default_rng(0)
    angles = np.column_stack([rng.uniform(0, 360, SAMPLES), *(tilt_deg * rng.uniform(-1, 1, (2, SAMPLES)))])
    to_body = Rotation.from_euler("ZYX", angles, degrees=True).inv()
    field_nT, down = to_body.apply(FIELD_ENU_NT), to_body.apply([0.0, 0.0, -1.0])
    measured = field_nT @ np.linalg.inv(TURNED).T + OFFSET_NT
    return measured + noise_nT * rng.normal(size=measured.shape), down


@pytest.mark.parametrize("wrong_deg", [0.0, 0.4])
def test_the_iron_is_the_true_one_with_the_turn_of_the_sensor(wrong_deg: float) -> None:
    """The strength alone does not see how the sensor sits; a constant error of the given dip bends nothing."""
    measured, down = _measured_with_dip(60.0)
    given = np.full(SAMPLES, DIP_RAD + np.radians(wrong_deg))
    iron = fit_iron(measured, np.full(SAMPLES, STRENGTH_NT), TIME_S, STANDARD, Level(down, given))
    assert np.allclose(iron.matrix, TURNED, atol=3e-4)
    assert np.allclose(iron.offset_nT, OFFSET_NT, atol=8.0)


def test_nearly_level_the_prior_stands_for_what_is_not_shown() -> None:
    measured, down = _measured_with_dip(0.5)
    given = np.full(SAMPLES, DIP_RAD)
    iron = fit_iron(measured, np.full(SAMPLES, STRENGTH_NT), TIME_S, STANDARD, Level(down, given))
    size = np.linalg.svd(iron.matrix)[1]
    assert 0.5 < size.min() < size.max() < 1.5


def test_counts_with_a_dip_are_brought_to_the_unit_of_the_field() -> None:
    measured, down = _measured_with_dip(60.0)
    of = (np.full(SAMPLES, STRENGTH_NT), TIME_S, STANDARD, Level(down, np.full(SAMPLES, DIP_RAD)))
    counts, same = (fit_iron(values, *of) for values in (measured / 100, measured))
    assert np.allclose(counts.matrix / 100, same.matrix, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("by_dip", [False, True])
def test_slopes_are_those_of_small_differences(by_dip: bool) -> None:
    rng = np.random.default_rng(4)
    y, down = rng.normal(size=(20, 3)), rng.normal(size=(20, 3))
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    level = Level(down, rng.uniform(-1, 1, 20)) if by_dip else None
    F, p = rng.uniform(0.9, 1.1, 20), 13 if by_dip else 12
    theta = np.r_[np.eye(3).ravel(), np.zeros(4)][:p] + 0.1 * rng.normal(size=p)
    either = ([deviations(theta + sign * one, y, F, level)[0] for one in 1e-6 * np.eye(p)] for sign in (1, -1))
    differences = [(above - below) / 2e-6 for above, below in zip(*either, strict=True)]
    assert np.allclose(deviations(theta, y, F, level)[1], np.stack(differences, axis=2), atol=1e-7)


@pytest.mark.parametrize(("share", "left_out"), [(0.15, True), (0.25, False)])
def test_far_samples_are_failures_unless_they_are_many(share: float, left_out: bool) -> None:
    """A fifth that is off is a gap, and bends either fit."""
    rng, n = np.random.default_rng(0), len(KNOWN_NT)
    far = np.arange(n) < share * n
    up = rng.normal(size=(n, 3))
    measured = FIELD_NT * up / np.linalg.norm(up, axis=1, keepdims=True) * (1 + 0.2 * far[:, None])
    measured += NOISE_NT * rng.normal(size=(n, 3))
    size = np.linalg.det(fit_iron(measured, KNOWN_NT, TIME_S, STANDARD).matrix)
    assert bool(abs(size - 1) < 1e-3) is left_out
    either = 100.0 * far * np.where(np.arange(n) % 3, 1, -1)
    beta = robust_fit(np.ones((n, 1)), (rng.normal(size=n) + either)[:, None], STANDARD)
    assert (abs(float(beta[0, 0])) < 1.0) is left_out
