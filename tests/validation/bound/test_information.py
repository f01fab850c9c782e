"""The bound of the standard case, which others computed too, and laws that every bound keeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import get
from calib.models.levelled import STANDARD_GRAVITY_M_S2
from tests.calib import conftest as standard
from tests.validation.bound.experiments import level_turns, of_motion
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.knowledge import KNOWLEDGE
from validation.bound.levelled import GRAVITY_STD_M_S2

FIGURES = {
    "norm": ({"full": 0.5592, "pitch": 7.589, "auv": 423.6}, 0.005),
    "norm+gyro": ({"full": 0.556, "pitch": 6.75, "auv": 68.5}, 0.05),
    "vector": ({"full": 0.2938, "pitch": 1.1052, "auv": 9.799}, 0.005),
}


@pytest.mark.parametrize("knowledge", FIGURES)
@pytest.mark.parametrize("motion", ["full", "pitch", "auv"])
def test_the_standard_case(motion: str, knowledge: str) -> None:
    figures, tolerance = FIGURES[knowledge]
    assert Bound.of(of_motion(motion), knowledge).offset_rms_nT == pytest.approx(figures[motion], rel=tolerance)


@pytest.mark.parametrize("motion", ["full", "pitch", "auv"])
def test_who_knows_more_finds_it_no_worse(motion: str) -> None:
    norm, gyro, vector = (Bound.of(of_motion(motion), knowledge).offset_std_nT for knowledge in FIGURES)
    assert (vector <= gyro).all()
    assert (gyro <= norm).all()


def test_a_useless_gyro_is_none_and_a_perfect_one_leaves_one_direction() -> None:
    known = of_motion("pitch")
    norm = Bound.of(known, "norm").offset_rms_nT
    assert Bound.of(replace(known, gyro_std_rad_s=1e3), "norm+gyro").offset_rms_nT == pytest.approx(norm, rel=1e-3)
    better = [Bound.of(replace(known, gyro_std_rad_s=std), "norm+gyro").offset_rms_nT for std in (1e-2, 1e-3, 1e-4)]
    assert better == sorted(better, reverse=True)


@pytest.mark.parametrize("motion", ["pitch", "auv"])
def test_a_useless_accelerometer_is_none_and_a_better_one_tells_more(motion: str) -> None:
    known = of_motion(motion)
    without = Bound.of(known, "norm+gyro").offset_rms_nT
    with_it = [
        Bound.of(replace(known, accel_std_m_s2=std), "norm+gyro+accel").offset_rms_nT for std in (1e4, 0.1, 0.02, 2e-3)
    ]
    assert with_it[0] == pytest.approx(without, rel=3e-3)
    assert with_it == sorted(with_it, reverse=True)
    assert with_it[2] < 0.95 * without


@pytest.mark.parametrize("gyro_scale_std", [0.0, 0.005])
def test_attitudes_are_eliminated_as_a_dense_least_squares_does(gyro_scale_std: float) -> None:
    """Fields and forces of a chain turned by finite steps, the derivative taken of the whole by differences."""
    known = replace(of_motion("pitch", 30), gyro_scale_std=gyro_scale_std)
    rows = _levelled_rows(known)
    square = rows.T @ rows
    expected = np.linalg.inv(np.linalg.inv(square)[:9, :9])
    found = Bound.of(known, "norm+gyro+accel").information.matrix
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-3 * np.abs(expected).max() * 1e-3)


def _levelled_rows(known: Experiment) -> np.ndarray:
    """Of (b, S, inclination, gravity, force's bias, gyro's scale and bias, turn of each sample), over their noise."""
    n, places = len(known.field_nT), [(i, j) for i in range(3) for j in range(i, 3)]
    assert known.turns is not None
    assert known.up is not None
    rate, scaled = known.rate_rad_s, 3 * (known.gyro_scale_std > 0)
    across = np.cross(known.directions, known.up)
    across /= np.linalg.norm(across, axis=1)[:, None]

    def values(p: np.ndarray) -> np.ndarray:
        S = known.matrix.copy()
        for (i, j), value in zip(places, p[3:9], strict=True):
            S[i, j] += value / known.strength_nT
            S[j, i] = S[i, j]
        own = Rotation.from_rotvec(p[17 + scaled :].reshape(n, 3))
        inclined = Rotation.from_rotvec(p[9] * across)
        field = own.apply(inclined.apply(known.field_nT)) @ S.T + p[:3]
        force = (STANDARD_GRAVITY_M_S2 + p[10]) * own.apply(known.up) + p[11:14]
        wrong = p[-3 * n - 3 : -3 * n] + (rate * p[14:17] if scaled else 0.0)
        turns = Rotation.from_matrix(known.turns)
        ahead = Rotation.from_rotvec(wrong * known.step_s[:, None]) * turns * own[:-1]
        off = (own[1:] * turns * ahead.inv()).as_rotvec()
        over = known.gyro_std_rad_s * known.step_s[:, None]
        known_before = np.array([p[10] / GRAVITY_STD_M_S2, *(p[14:17] / known.gyro_scale_std if scaled else ())])
        parts = (field / known.noise_std_nT, force / known.accel_std_m_s2, off / over)
        return np.concatenate([*(part.ravel() for part in parts), known_before])

    steps = np.concatenate([np.full(9, 1.0), [1e-6], np.full(4, 1e-4), np.full(scaled + 3, 1e-5), np.full(3 * n, 1e-6)])
    ways = np.diag(steps)
    return np.array([(values(way) - values(-way)) / (2.0 * step) for way, step in zip(ways, steps, strict=True)]).T


@pytest.mark.parametrize("motion", ["pitch", "auv"])
def test_a_gyros_scale_that_is_hardly_known_costs_something_and_one_that_is_known_nothing(motion: str) -> None:
    """Between an exact gyro and none."""
    known = of_motion(motion)
    stated = [
        Bound.of(replace(known, gyro_scale_std=std), "norm+gyro").offset_rms_nT for std in (0.0, 1e-7, 0.005, 10.0)
    ]
    assert stated[1] == pytest.approx(stated[0], rel=1e-6)
    assert stated == sorted(stated)
    assert stated[2] > 1.05 * stated[0]
    assert stated[3] < Bound.of(known, "norm").offset_rms_nT


def test_the_gyros_scale_is_eliminated_as_a_dense_least_squares_does() -> None:
    """Directions, offset, S, bias and scales of 240 samples at once, by differences of the model itself."""
    known = replace(of_motion("pitch", 240), gyro_scale_std=0.02, gyro_std_rad_s=1e-3)
    J = _dense_rows(known)
    information = J.T @ J
    size = np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information / np.outer(size, size)) / np.outer(size, size)
    found = Bound.of(known, "norm+gyro").offset_std_nT
    np.testing.assert_allclose(found, np.sqrt(np.diag(covariance)[:3]), rtol=3e-3)


def _dense_rows(known: Experiment) -> np.ndarray:
    """d (measurements, gyro steps, prior) / d (offset, S, bias, scales, two angles a sample), over the noise."""
    n, rate, F = len(known.field_nT), known.rate_rad_s, known.strength_nT
    assert rate is not None
    u = known.directions
    first = np.cross(u, [0.3, -0.5, 0.8])
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(u, first)
    upper = np.triu_indices(3)

    def values(p: np.ndarray) -> np.ndarray:
        S = known.matrix.copy()
        S[upper] += p[3:9] / F
        S.T[upper] = S[upper]
        turned = u + p[15::2, None] * first + p[16::2, None] * second
        turned /= np.linalg.norm(turned, axis=1)[:, None]
        seen = F * turned @ S.T + p[:3]
        step = Rotation.from_rotvec(-(rate * (1.0 + p[12:15]) - p[9:12]) * known.step_s[:, None])
        off = (turned[1:] - step.apply(turned[:-1])) / (known.gyro_std_rad_s * known.step_s)[:, None]
        return np.concatenate([(seen / known.noise_std_nT).ravel(), off.ravel(), p[12:15] / known.gyro_scale_std])

    steps = np.concatenate([np.full(9, 1.0), np.full(3, 1e-5), np.full(3, 1e-4), np.full(2 * n, 1e-5)])
    ways = np.diag(steps)
    return np.array([(values(way) - values(-way)) / (2.0 * step) for way, step in zip(ways, steps, strict=True)]).T


@pytest.mark.parametrize("knowledge", KNOWLEDGE)
def test_turning_the_body_turns_the_offsets_covariance_and_noise_scales_it(knowledge: str) -> None:
    known = replace(of_motion("pitch"), matrix=np.eye(3))
    R = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    one, other = Bound.of(known, knowledge), Bound.of(known.turned(R), knowledge)
    offset = other.covariance[:3, :3]
    np.testing.assert_allclose(offset, R @ one.covariance[:3, :3] @ R.T, atol=1e-6 * np.trace(offset))
    if "gyro" not in knowledge:
        noisier = Bound.of(replace(known, noise_std_nT=30.0), knowledge)
        np.testing.assert_allclose(noisier.offset_std_nT, 3 * one.offset_std_nT, rtol=1e-9)


def test_vector_least_squares_is_at_its_bound() -> None:
    bound = Bound.of(of_motion("pitch"), "vector")
    fits = [get("vector_least_squares").fit(standard.recording("pitch", k), standard.REFERENCE) for k in range(30)]
    errors = np.array([fit.offset_nT - standard.HARD_NT for fit in fits])
    assert np.sqrt(np.mean(np.sum(errors**2, axis=1))) == pytest.approx(bound.offset_rms_nT, rel=0.25)


@pytest.mark.parametrize("knowledge", FIGURES)
def test_what_a_level_turn_does_not_tell_is_infinite(knowledge: str) -> None:
    bound = Bound.of(level_turns(), knowledge)
    assert np.isinf(bound.offset_std_nT[2])
    assert np.isinf(bound.matrix_std[2, 2])
    assert np.isfinite(bound.matrix_std[0, 1])
