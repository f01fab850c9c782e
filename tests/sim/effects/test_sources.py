"""Fields of bodies: against the textbook dipole, magpylib's magnets, and the field equations."""

from __future__ import annotations

import magpylib
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from sim.effects.sources import LocalDipole, dipole_field_nT, line_field_nT

MOMENT = np.array([300.0, -200.0, 500.0])
EXTENT = np.array([4.0, 3.0, -2.0])


def test_dipole_on_its_axis_and_beside_it():
    way = np.array([[0, 0, 10.0], [10.0, 0, 0]])
    field = dipole_field_nT(way, np.array([0, 0, 1000.0]))
    np.testing.assert_allclose(field, [[0, 0, 200.0], [0, 0, -100.0]], rtol=1e-6, atol=1e-9)


def test_dipole_off_axis_is_the_textbook_formula():
    way = np.random.default_rng(0).normal(size=(200, 3)) * 20
    r = np.linalg.norm(way, axis=1)[:, None]
    textbook = 100 * (3 * (way @ MOMENT)[:, None] * way / r**5 - MOMENT / r**3)
    np.testing.assert_allclose(dipole_field_nT(way, MOMENT), textbook, rtol=1e-9)


def test_dipole_is_magpylibs():
    way = np.random.default_rng(2).normal(size=(200, 3)) * 20
    field = magpylib.misc.Dipole(moment=MOMENT).getB(way) * 1e9
    np.testing.assert_allclose(dipole_field_nT(way, MOMENT), field, rtol=1e-9)


def test_effect_gives_the_dipoles_field_in_the_body_frame(states):
    state = states(300)
    effect = LocalDipole((3, -4, -60), tuple(1e4 * MOMENT))
    label = effect.apply(state, state.field_nT, np.random.default_rng(0), {})
    world = dipole_field_nT(state.pos_enu_m - [3, -4, -60], 1e4 * MOMENT)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", state.R_wb, label), world, rtol=1e-9, atol=1e-9)


def around(n=400):
    return EXTENT / 2 + np.random.default_rng(1).normal(size=(n, 3)) * 6


def test_a_line_is_the_sum_of_its_dipoles():
    way = around()
    nodes, weights = np.polynomial.legendre.leggauss(400)
    pieces = zip((nodes + 1) / 2, weights / 2, strict=True)
    string = sum(w * dipole_field_nT(way - s * EXTENT, MOMENT) for s, w in pieces)
    np.testing.assert_allclose(line_field_nT(way, MOMENT, EXTENT), string, rtol=1e-6, atol=1e-5)


def test_a_line_is_a_thin_cylinder_of_magpylib():
    way = around()
    length, diameter = np.linalg.norm(EXTENT), 0.02
    axis = Rotation.align_vectors([EXTENT / length], [[0, 0, 1.0]])[0]
    volume = np.pi * diameter**2 / 4 * length
    magnet = magpylib.magnet.Cylinder(
        position=EXTENT / 2,
        orientation=axis,
        dimension=(diameter, length),
        magnetization=axis.inv().apply(MOMENT / volume),
    )
    field = line_field_nT(way, MOMENT, EXTENT)
    np.testing.assert_allclose(field, magnet.getB(way) * 1e9, rtol=1e-3, atol=1e-3 * np.abs(field).min())


def test_a_short_line_is_a_dipole_and_a_far_one_too():
    way = around()
    field = dipole_field_nT(way, MOMENT)
    slack = 1e-3 * np.linalg.norm(field, axis=1).min()
    np.testing.assert_allclose(line_field_nT(way, MOMENT, EXTENT * 1e-6), field, rtol=1e-4, atol=slack)
    far = way * 1e4
    field = dipole_field_nT(far - EXTENT / 2, MOMENT)
    np.testing.assert_allclose(line_field_nT(far, MOMENT, EXTENT), field, rtol=1e-4, atol=1e-3 * np.abs(field).max())


@pytest.mark.parametrize("ahead", [1.5, 3.0, 300.0])
def test_a_line_is_smooth_across_its_own_axis_beyond_an_end(ahead):
    side = np.array([3.0, -4.0, 0.0])
    off_axis = np.array([0.0, 1e-12, 1e-9, 1e-6])
    field = line_field_nT(ahead * EXTENT + off_axis[:, None] * side, MOMENT, EXTENT)
    np.testing.assert_allclose(field, np.tile(field[0], (4, 1)), rtol=1e-4)


def test_a_lines_field_has_neither_sources_nor_currents():
    step = 1e-3
    for point in around(20):
        shifts = np.vstack([step * np.eye(3), -step * np.eye(3)])
        field = line_field_nT(point + shifts, MOMENT, EXTENT)
        gradient = (field[:3] - field[3:]) / (2 * step)
        slack = 1e-4 * np.abs(gradient).max()
        assert abs(np.trace(gradient)) < slack
        assert np.abs(gradient - gradient.T).max() < slack


@pytest.mark.parametrize("extent", [(0, 0, 0), (1, 2, 3)])
def test_a_path_through_the_source_is_refused(states, extent):
    state = states(20)
    with pytest.raises(InputError, match="goes through the source"):
        LocalDipole(state.pos_enu_m[7], (1, 2, 3), extent).apply(state, state.field_nT, np.random.default_rng(0), {})
