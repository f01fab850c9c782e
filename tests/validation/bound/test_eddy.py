"""Eddy currents beside offset and matrix: 21 parameters, against dense columns and a calibrator that finds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.methods.vector_least_squares import VectorLeastSquares
from scenarios.errors import InputError
from tests.calib import conftest as standard
from tests.validation.bound.experiments import level_turns, of_motion
from validation.bound.bound import Bound


def dense(samples: int) -> np.ndarray:
    """Inverse of the whole information (21, 21) of the standard pitch, dh/dt the central difference of the field."""
    known = of_motion("pitch", samples)
    h = known.field_nT
    rate = np.gradient(h, known.step_s[0], axis=0)
    x = np.column_stack([np.ones(len(h)), h / known.strength_nT, rate])
    return np.linalg.inv(x.T @ x / known.noise_std_nT**2)


def test_offset_matrix_and_eddy_term_are_those_of_the_dense_information() -> None:
    covariance = dense(3600)
    bound = Bound.of(of_motion("pitch"), "vector+eddy")
    np.testing.assert_allclose(bound.offset_std_nT, np.sqrt(covariance[0, 0]), rtol=1e-3)
    np.testing.assert_allclose(
        bound.matrix_std * bound.strength_nT, np.tile(np.sqrt(np.diag(covariance)[1:4]), (3, 1)), rtol=1e-3
    )
    assert bound.information.eddy_std_s is not None
    np.testing.assert_allclose(
        bound.information.eddy_std_s, np.tile(np.sqrt(np.diag(covariance)[4:]), (3, 1)), rtol=1e-3
    )


def test_the_elimination_is_exact() -> None:
    """The inverse of all 21 columns at once, an axis after the other, with the same rate: to 1e-8."""
    known = of_motion("auv", 600)
    x = np.column_stack([np.ones(600), known.field_nT / known.strength_nT, known.field_rate_nT_s])
    whole = np.kron(np.eye(3), x.T @ x) / known.noise_std_nT**2
    size = np.sqrt(np.diag(whole))
    covariance = np.linalg.inv(whole / np.outer(size, size)) / np.outer(size, size)
    bound = Bound.of(known, "vector+eddy")
    np.testing.assert_allclose(bound.offset_std_nT, np.sqrt(np.diag(covariance)[[0, 7, 14]]), rtol=1e-8)


def test_vector_least_squares_with_an_eddy_term_is_at_its_bound() -> None:
    bound = Bound.of(of_motion("pitch"), "vector+eddy")
    method = VectorLeastSquares(eddy=True)
    fits = [method.fit(standard.recording("pitch", k), standard.REFERENCE) for k in range(30)]
    errors = np.array([fit.offset_nT - standard.HARD_NT for fit in fits])
    assert np.sqrt(np.mean(np.sum(errors**2, axis=1))) == pytest.approx(bound.offset_rms_nT, rel=0.25)
    eddy = np.array([fit.eddy_s for fit in fits])
    assert bound.information.eddy_std_s is not None
    ratio = np.sqrt(np.mean(eddy**2, axis=0)) / bound.information.eddy_std_s
    assert np.sqrt(np.mean(ratio**2)) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("motion", ["full", "pitch", "auv"])
def test_more_to_find_is_found_no_better(motion: str) -> None:
    with_eddy, without = (Bound.of(of_motion(motion), word).offset_std_nT for word in ("vector+eddy", "vector"))
    assert (with_eddy >= without * (1 - 1e-9)).all()


def test_a_steady_level_turn_does_not_tell_eddy_currents_from_soft_iron() -> None:
    """dh/dt is a fixed matrix times h there."""
    bound = Bound.of(level_turns(), "vector+eddy")
    assert np.isinf(bound.matrix_std[0, 1])
    assert bound.information.eddy_std_s is not None
    assert np.isinf(bound.information.eddy_std_s[0, 0])


def test_without_turns_nothing_tells_the_rate() -> None:
    known = replace(of_motion("full", 200), turns=None)
    with pytest.raises(InputError, match="rate of the field is unknown"):
        Bound.of(known, "vector+eddy")


def test_the_rate_is_that_of_a_steady_rotation() -> None:
    """0.01 rad a sample about z, field (x, y): dh/dt = -omega x h."""
    known = level_turns()
    rate = known.field_rate_nT_s
    assert rate is not None
    turned = Rotation.from_rotvec([0.0, 0.0, -np.pi / 2]).apply(known.field_nT * [1.0, 1.0, 0.0])
    np.testing.assert_allclose(rate, 0.1 * turned, atol=1e-6 * known.strength_nT)
