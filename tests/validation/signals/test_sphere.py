"""Cells of equal area, and holes of known size."""

from __future__ import annotations

import numpy as np
import pytest

from validation.signals.sphere import BAND_DEG, cells, directions, largest_hole

GRID = cells()


def uniform(samples: int) -> np.ndarray:
    return directions(np.random.default_rng(0).normal(0, 1, (samples, 3)))


def test_cells_have_the_same_area_and_fill_the_sphere() -> None:
    """Archimedes: the area between two heights is 2 pi times their distance."""
    low, high, bottom, top = GRID.edges().T
    area = (high - low) * (top - bottom)
    np.testing.assert_allclose(area, 4 * np.pi / GRID.total, rtol=1e-12)


def test_directions_fall_evenly_into_the_cells() -> None:
    counts = np.bincount(GRID.index(uniform(200_000)), minlength=GRID.total)
    expected = 200_000 / GRID.total
    assert ((counts - expected) ** 2 / expected).sum() < GRID.total + 5 * np.sqrt(2 * GRID.total)


def test_the_middle_of_a_cell_is_in_it() -> None:
    centres = GRID.centres()
    np.testing.assert_allclose(np.linalg.norm(centres, axis=1), 1, atol=1e-12)
    assert GRID.index(centres).tolist() == list(range(GRID.total))


def test_poles_and_the_date_line_are_in_a_cell() -> None:
    edges = np.array([[0, 0, 1], [0, 0, -1], [1, -1e-18, 0], [-1, 0, 0], [1, 0, 0]], float)
    beside = np.array([[1e-6, 0, 1], [1e-6, 0, -1], [1, -1e-6, 0], [-1, -1e-6, 0], [1, 1e-6, 0]])
    assert GRID.index(edges).tolist() == GRID.index(directions(beside)).tolist()


def test_what_has_no_direction_is_left_out() -> None:
    vectors = np.array([[0, 0, 0], [np.nan, 1, 0], [np.inf, 0, 0], [0, 3, 4]], float)
    np.testing.assert_allclose(directions(vectors), [[0, 0.6, 0.8]])


@pytest.mark.parametrize("radius_deg", [30.0, 60.0])
def test_a_hole_of_known_size_and_place(radius_deg: float) -> None:
    """Seen from the middle of the cell that is nearest to its own, at most half a cell's diagonal away."""
    middle = np.array([0.6, 0.0, -0.8])
    seen = uniform(100_000)
    seen = seen[seen @ middle < np.cos(np.radians(radius_deg))]
    hole_deg, at = largest_hole(seen)
    assert 0 <= radius_deg - hole_deg < BAND_DEG / np.sqrt(2)
    assert np.degrees(np.arccos(at @ middle)) < BAND_DEG / np.sqrt(2)


def test_the_largest_hole_of_many_vectors_is_that_of_every_centre_against_every_vector() -> None:
    rng = np.random.default_rng(1)
    for tilt in (0.2, 1.0, 3.0):
        seen = directions(rng.normal(size=(40_000, 3)) + tilt * rng.normal(size=3))
        cosines = (cells().centres() @ seen.T).max(axis=1)
        hole_deg, at = largest_hole(seen)
        assert hole_deg == pytest.approx(np.degrees(np.arccos(cosines.min())))
        np.testing.assert_array_equal(at, cells().centres()[np.argmin(cosines)])
