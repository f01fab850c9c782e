"""Other arrangements and rotations of [Ding2021]'s array: tensors of known fields, errors by the ratio of size."""

from __future__ import annotations

import numpy as np
import pytest

from calib.models.sensor_array import tensor
from papers.ding2021.geometry import ARRANGEMENTS, CROSS, places, reach, tensors
from papers.ding2021.geometry_rows import dipole_error, geometry_rows, geometry_trial, passed_on
from papers.ding2021.rotations import RANDOM, THREE, TURNS, rotation_rows, rotation_trial, turned
from papers.ding2021.trials import BASELINE_M, field_enu_nT
from scenarios.arrays import Array

G = np.array([[3.0, -2.0, 5.0], [-2.0, 4.0, 1.0], [5.0, 1.0, -7.0]])


def fields(place_m: Array) -> Array:
    """Fields (k, 1, 3) of the gradient G, which is symmetric and trace-free, about a large mean."""
    return np.array([[30_000.0, -20_000.0, 10_000.0] + G @ r for r in place_m])[:, None]


@pytest.mark.parametrize("name", ARRANGEMENTS)
def test_every_arrangement_is_exact_in_an_even_gradient(name: str) -> None:
    place = BASELINE_M * places(name)
    np.testing.assert_allclose(place.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(tensors(place, fields(place))[0], [3.0, -2.0, 5.0, 4.0, 1.0], atol=1e-8)


def test_arrangements_have_the_shapes_of_their_names() -> None:
    sides = {}
    for name in ARRANGEMENTS:
        place = places(name)
        apart = np.linalg.norm(place[:, None] - place, axis=2)[np.triu_indices(len(place), 1)]
        sides[name] = np.round(sorted(apart), 6).tolist()
    assert sides["triangle"] == [1.0] * 3
    assert sides["regular tetrahedron"] == [1.0] * 6
    assert sides["right-angled tetrahedron"] == pytest.approx([1.0] * 3 + [2**0.5] * 3, abs=1e-6)
    assert sides["square"] == pytest.approx([1.0] * 4 + [2**0.5] * 2, abs=1e-6)
    assert sides[CROSS] == pytest.approx([0.5**0.5] * 4 + [1.0] * 2, abs=1e-6)
    assert reach("square") == pytest.approx(0.5**0.5)


def test_the_cross_gives_the_paper_s_differences() -> None:
    place, noise = BASELINE_M * places(CROSS), np.random.default_rng(1).standard_normal((4, 6, 3))
    ours, printed = tensors(place, noise), tensor(noise, BASELINE_M)
    np.testing.assert_allclose(np.delete(ours, 1, axis=1), np.delete(printed, 1, axis=1))
    other = (noise[1] - noise[3])[:, 0] / BASELINE_M  # dBx/dy, the second estimate of Bxy
    np.testing.assert_allclose(ours[:, 1], (printed[:, 1] + other) / 2)


@pytest.mark.parametrize(("name", "power"), [(CROSS, 2), ("square", 2), ("triangle", 1), ("regular tetrahedron", 1)])
def test_errors_fall_with_a_power_of_the_distance(name: str, power: int) -> None:
    near, far = (dipole_error(BASELINE_M * places(name), r) for r in (4.0, 8.0))
    assert near / far == pytest.approx(2.0**power, rel=0.05)


def test_noise_is_passed_on_as_it_is() -> None:
    """Cross: four components sqrt(2) s / d, and Bxy from two estimates, s / d."""
    assert passed_on(BASELINE_M * places(CROSS)) == pytest.approx(np.sqrt((4 * 2 + 1) / 5) / BASELINE_M)
    place = BASELINE_M * places("triangle")
    noise = np.random.default_rng(2).standard_normal((3, 20_000, 3))
    assert np.sqrt(np.mean(tensors(place, noise) ** 2)) == pytest.approx(passed_on(place), rel=0.02)


def test_whole_turns_are_about_the_axes_they_name() -> None:
    for axes in TURNS.values():
        R_wb = turned(axes)
        assert len(R_wb) == 200
        field = np.einsum("nij,i->nj", R_wb, field_enu_nT())
        for axis, part in zip(axes, np.array_split(field, len(axes)), strict=True):
            assert np.ptp(part[:, axis]) < 1e-6 < np.ptp(part[:, (axis + 1) % 3])


def test_rows_of_the_rotations() -> None:
    trials = [rotation_trial(seed) for seed in (0, 1)]
    assert trials[0].bound_nT[RANDOM] < trials[0].bound_nT[THREE]
    assert {t.results[name].status for t in trials for name in (RANDOM, THREE)} == {"ok"}
    three, fewer = rotation_rows(trials)
    assert (three.verdict, fewer.verdict) == ("holds", "not comparable")
    assert fewer.ours.count("unobservable in 2 of 2") == 3


def test_rows_of_the_arrangements() -> None:
    trials = [geometry_trial(seed) for seed in (0, 1)]
    rows = geometry_rows(trials)
    assert [row.verdict for row in rows] == ["holds", "does not hold", "not comparable"]
    for trial in trials:
        assert set(trial.tensor_nT_m) == set(ARRANGEMENTS)
        assert max(trial.offset_nT.values()) < 5.0
