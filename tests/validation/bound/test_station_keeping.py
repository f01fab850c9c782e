"""The limit of a vehicle that stays in its place: what it demands, that no such flight is below it, and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from scenarios.paths.hover import GRAVITY_M_S2
from sim.vehicles.quadrotor import Quadrotor
from tests.validation.bound.test_limit import known_of
from validation.bound.experiment import Experiment
from validation.bound.goal import OFFSET
from validation.bound.limit import Tilts, candidates, criterion, limit, optimal, sample_rows
from validation.bound.station_keeping import GAP, balanced, staying_limit

WIDE = Tilts(45.0, 45.0)


@pytest.fixture(scope="module")
def known() -> Experiment:
    return known_of("pitch")


def test_it_is_what_another_solver_finds() -> None:
    """Ten random candidates beside their mirrors, three parameters, by sequential quadratic programming."""
    rng = np.random.default_rng(4)
    rows, moments = rng.normal(size=(20, 1, 3)), rng.normal(size=(10, 2))
    moments, mirrored = np.concatenate([moments, -moments]), np.roll(np.arange(20), 10)

    def mean_square(weights: np.ndarray) -> float:
        return float(np.trace(np.linalg.inv(np.einsum("k,kri,krj->ij", weights, rows, rows))))

    found = minimize(
        mean_square,
        np.full(20, 0.05),
        method="SLSQP",
        bounds=[(1e-9, 1.0)] * 20,
        constraints=[
            {"type": "eq", "fun": lambda w: w.sum() - 1.0},
            {"type": "eq", "fun": lambda w: w @ moments},
        ],
        options={"maxiter": 500, "ftol": 1e-12},
    )
    variance, gap, weights = balanced(rows, np.eye(3), moments, mirrored)
    assert found.success
    assert gap < GAP
    assert found.fun * (1 - 1e-6) < variance < found.fun * (1 + 2 * GAP)
    np.testing.assert_allclose(weights @ moments, 0.0, atol=1e-9)
    assert optimal(rows, np.eye(3))[0] < 0.98 * variance


@pytest.mark.parametrize(("knowledge", "ratio"), [("norm", 1.07), ("vector", 1.37)])
def test_its_thrust_is_vertical_on_the_average_and_costs(knowledge: str, ratio: float, known: Experiment) -> None:
    """At a constant height thrust is weight over the cosine of the tilt: its horizontal part adds up to nothing."""
    least, found = limit(known, knowledge, WIDE), staying_limit(known, knowledge, WIDE)
    thrust = found.attitudes.apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(found.weights @ (thrust / thrust[:, 2:]), [0.0, 0.0, 1.0], atol=1e-9)
    assert found.gap < GAP
    assert found.value / least.value == pytest.approx(ratio, abs=0.01)


@pytest.mark.parametrize(("out_m_s", "least_ratio"), [(0.0, 1.36), (29.0, 1.26)])
def test_neither_is_who_flies_out_fast_and_slowly_back(out_m_s: float, least_ratio: float, known: Experiment) -> None:
    """By duality: no design v is below f^2 / (v d), and v d <= max(d - push l) + |l| c for any l.

    Back where it was, at most v_out fast, a vehicle has a drag of up to c = (3 - 2 sqrt 2) D v_out^2 on the average:
    that is out for 0.29 of the time. At 45 degrees of roll and pitch it gets to 29 m/s.
    """
    attitudes, rows = candidates(known, "vector", WIDE)
    found, wanted = staying_limit(known, "vector", WIDE), OFFSET.factor(known, "vector")
    square, slope = criterion(rows, found.weights, wanted, None)
    up, mean_drag = attitudes.as_matrix()[:, :, 2], (3.0 - np.sqrt(8.0)) * Quadrotor.drag_1_m * out_m_s**2
    pushes = GRAVITY_M_S2 * up[:, :2] / up[:, 2:]

    def most(factor: np.ndarray) -> float:
        return float(np.max(slope / square - pushes @ factor) + mean_drag * np.linalg.norm(factor))

    best = minimize(most, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-6})
    assert np.sqrt(square / best.fun) > least_ratio * limit(known, "vector", WIDE).value


def test_a_little_tilt_costs_next_to_nothing(known: Experiment) -> None:
    least, found = (of(known, "norm", Tilts(5.0, 5.0)).value for of in (limit, staying_limit))
    assert least < found < 1.005 * least


@pytest.mark.parametrize("seed", range(3))
def test_no_flight_that_stays_is_below_it(seed: int, known: Experiment) -> None:
    """Attitudes at random, each with a push back on another heading that makes up for it."""
    rng, least = np.random.default_rng(seed), staying_limit(known, "vector", WIDE).value
    tilts = np.radians(rng.uniform(20.0, 45.0, 30))
    toward = rng.uniform(0.0, 2 * np.pi, 30)
    rows = []
    for azimuth in (toward, toward + np.pi):
        lean = Rotation.from_rotvec(tilts[:, None] * np.column_stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth]))
        attitudes = lean * Rotation.from_euler("z", rng.uniform(0.0, 360.0, (30, 1)), degrees=True)
        rows.append(sample_rows(known, "vector", attitudes))
    told = np.concatenate(rows).reshape(-1, 12) * np.sqrt(len(known.field_nT) / 60)
    assert np.sqrt(np.trace(np.linalg.inv(told.T @ told)[:3, :3])) > least * (1 - GAP)
