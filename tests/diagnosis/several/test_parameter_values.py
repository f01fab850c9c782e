"""Parameters from coefficients: their errors by the slopes, and a listed value moved to where the column fits."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.library.candidates import Candidate
from diagnosis.several.parameter_values import parameters_of
from sim.effects import EFFECTS
from sim.effects.currents import MotorCurrent
from sim.effects.iron import SoftIron
from tests.diagnosis.synthetic import problem

COVARIANCE = np.array([[0.04, 0.01, 0.0], [0.01, 0.09, 0.0], [0.0, 0.0, 0.16]])


def test_the_errors_of_a_linear_effect_are_those_of_its_coefficients() -> None:
    c = np.array([3.0, -2.0, 4.0])
    effect, spread = parameters_of(Candidate(MotorCurrent), c, COVARIANCE, problem(n=300))
    assert isinstance(effect, MotorCurrent)
    assert effect.gain_nT_A == pytest.approx(tuple(c))
    assert spread["gain_nT_A"] == pytest.approx([0.2, 0.3, 0.4], rel=1e-6)
    certain = parameters_of(Candidate(MotorCurrent), c, np.diag([0.04, 0.0, 0.16]), problem(n=300))[1]
    assert certain["gain_nT_A"] == pytest.approx([0.2, 0.0, 0.4], rel=1e-6)


def test_errors_go_with_the_slopes_of_many_parameters() -> None:
    """Against the spread of parameters of drawn coefficients."""
    rng = np.random.default_rng(2)
    candidate, here = Candidate(SoftIron), problem(n=300)
    k = candidate.columns(here).shape[2]
    c, root = rng.normal(0.0, 0.05, k), rng.normal(0.0, 0.002, (k, k))
    _, spread = parameters_of(candidate, c, root @ root.T, here)
    drawn = [candidate.to_effect(c + root @ rng.normal(size=k)) for _ in range(2000)]
    for name, std in spread.items():
        seen = np.std([np.asarray(getattr(one, name)) for one in drawn], axis=0)
        np.testing.assert_allclose(std, seen, rtol=0.1, atol=1e-9)


LISTED = [one for one in EFFECTS if one.name in ("latency", "bandwidth")]


@pytest.mark.parametrize("kind", LISTED, ids=lambda kind: kind.name)
def test_a_listed_value_is_moved_by_the_power_that_its_column_goes_with(kind) -> None:  # type: ignore[no-untyped-def]
    """A column of twice the listed value, as far as its size is a power of it, has the coefficient of that size."""
    here = problem(n=600)
    name = next(p.name for p in kind.parameters() if p.name in dict(Candidate.of(kind(**kind.example)).nonlinear))
    value = float(kind.example[name])
    candidate = Candidate(kind, ((name, value),))
    sizes = [np.linalg.norm(candidate.at({name: by * value}).columns(here)) for by in (1.0, 1.05)]
    effect, spread = parameters_of(candidate, np.array([sizes[1] / sizes[0]]), np.array([[0.01]]), here)
    assert getattr(effect, name) == pytest.approx(1.05 * value, rel=5e-3)
    power = np.log(sizes[1] / sizes[0]) / np.log(1.05)
    assert float(spread[name]) == pytest.approx(abs(1.05 * value * 0.1 / (sizes[1] / sizes[0] * power)), rel=0.05)
    vanishing, _ = parameters_of(candidate, np.array([-1.0]), np.array([[0.01]]), here)
    low, high = next((p.low, p.high) for p in kind.parameters() if p.name == name)
    assert low <= getattr(vanishing, name) <= high
