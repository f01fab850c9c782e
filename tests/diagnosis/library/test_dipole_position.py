"""Whether the place of a dipole is found on paths of every size, the field of a dipole written out here."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import propose_candidates
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.parameter_search import search_parameters
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, pose, recording

AT_NEAREST_NT = 300.0


def dipole_nT(pos_enu_m: Array, place_m: Array, axis: Array, nearest_m: float) -> Array:
    """A dipole's field (n, 3) with AT_NEAREST_NT beside its axis at a distance."""
    r = pos_enu_m - place_m
    d = np.linalg.norm(r, axis=1, keepdims=True)
    u = r / d
    return np.asarray(AT_NEAREST_NT * (nearest_m / d) ** 3 * (3 * u * (u @ axis)[:, None] - axis))


def past_a_dipole(extent_m: float, distance_m: float, seed: int) -> tuple[LinearProblem, Array]:
    """A path that goes past a dipole, and where that lies."""
    given, random = recording(1500, seed=seed), np.random.default_rng(seed)
    t = given.time_s / given.time_s[-1]
    pos = extent_m * np.column_stack([t, 0.15 * np.sin(12 * t), 0.02 * np.cos(7 * t)])
    place = pos[int(random.uniform(0.2, 0.8) * len(pos))] + distance_m * np.array([0, 0.5, -0.87])
    axis = random.normal(size=3)
    added = dipole_nT(pos, place, axis / np.linalg.norm(axis), distance_m)
    R_wb = pose(given, Known(FIELD_ENU_NT, STRENGTH_NT)).state.R_wb
    measured = given.mag_nT + np.einsum("nji,nj->ni", R_wb, added)
    return pose(replace(given, pos_enu_m=pos, mag_nT=measured), Known(FIELD_ENU_NT, STRENGTH_NT)), place


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("extent_m", "distance_m"), [(600.0, 250.0), (1500.0, 300.0), (30.0, 4.0), (2.5, 0.8)])
def test_a_dipole_is_found_on_a_path_of_any_size(extent_m: float, distance_m: float, seed: int) -> None:
    posed, _ = past_a_dipole(extent_m, distance_m, seed)
    residual = Baseline.of(posed).residual()
    thin = ThinnedPath.of(posed, residual)
    found = search_parameters(posed, residual, propose_candidates(posed)["local_dipole"])
    left = min((thin.residual(np.array(dict(one.nonlinear)["position_enu_m"])) ** 2).sum() for one in found)
    assert left < 0.01 * float(thin.y @ thin.y)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("distance_m", [20.0, 40.0])
def test_a_body_beside_a_long_path_does_not_lie_between_all_places_that_are_tried(distance_m: float, seed: int) -> None:
    """A refinement that starts farther off than a body is from the path may end elsewhere."""
    posed, place = past_a_dipole(1500.0, distance_m, seed)
    grid = ThinnedPath.of(posed, Baseline.of(posed).residual()).grid()
    assert np.linalg.norm(grid - place, axis=1).min() < distance_m
