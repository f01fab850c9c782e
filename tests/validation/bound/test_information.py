"""The bound of the standard case, which others computed too, and laws that every bound keeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import get
from tests.calib import conftest as standard
from tests.validation.bound.experiments import level_turns, of_motion
from validation.bound.bound import Bound
from validation.bound.information import KNOWLEDGE

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


@pytest.mark.parametrize("knowledge", KNOWLEDGE)
def test_turning_the_body_turns_the_offsets_covariance_and_noise_scales_it(knowledge: str) -> None:
    known = replace(of_motion("pitch"), matrix=np.eye(3))
    R = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    one, other = Bound.of(known, knowledge), Bound.of(known.turned(R), knowledge)
    offset = other.covariance[:3, :3]
    np.testing.assert_allclose(offset, R @ one.covariance[:3, :3] @ R.T, atol=1e-6 * np.trace(offset))
    if knowledge != "norm+gyro":
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
