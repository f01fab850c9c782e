"""Damped Gauss-Newton on problems whose minimum is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares

from calib.numerics.damped import NormalEquations, minimised


@dataclass(frozen=True)
class Decay:
    """y = a exp(-k t); no k below zero."""

    t: np.ndarray
    y: np.ndarray

    def residual(self, p):
        return p[0] * np.exp(-p[1] * self.t) - self.y

    def normal(self, p):
        r, e = self.residual(p), np.exp(-p[1] * self.t)
        J = np.column_stack((e, -p[0] * self.t * e))
        return NormalEquations(float(r @ r), J.T @ r, J.T @ J, 1e-4)

    def moved(self, p, step):
        return p + step if p[1] + step[1] >= 0 else None


@pytest.fixture(scope="module")
def decay():
    t = np.linspace(0, 5, 60)
    return Decay(t, 3 * np.exp(-0.8 * t) + np.random.default_rng(0).normal(0, 0.01, 60))


def test_minimum_is_that_of_another_solver(decay):
    found = minimised(decay, np.array([30.0, 4.0]), 50, 1e-6)
    other = least_squares(decay.residual, [3.0, 1.0], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.settled
    np.testing.assert_allclose(found.point, other.x, rtol=1e-7)
    assert found.history[-1] < 1e-6 < found.history[-2]


def test_steps_that_run_out_are_told(decay):
    found = minimised(decay, np.array([30.0, 4.0]), 3, 1e-6)
    assert not found.settled
    assert len(found.history) == 3


def test_no_step_leaves_what_is_allowed():
    rising = Decay(np.linspace(0, 1, 20), np.exp(np.linspace(0, 1, 20)))
    found = minimised(rising, np.array([1.0, 0.5]), 200, 1e-6)
    assert not found.settled
    assert found.point[1] >= 0


def test_a_parameter_that_nothing_depends_on_stays():
    @dataclass(frozen=True)
    class Flat:
        def normal(self, p):
            return NormalEquations(float((p[0] - 2) ** 2), np.array([p[0] - 2, 0.0]), np.diag([1.0, 0.0]), 1.0)

        def moved(self, p, step):
            return p + step

    found = minimised(Flat(), np.array([0.0, 7.0]), 20, 1e-9)
    np.testing.assert_allclose(found.point, [2.0, 7.0], atol=1e-8)
