"""Effects of the Earth's field: in time, in space, and through a turned navigation frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.effects.earth import AttitudeMisalignment, DiurnalDrift, FieldGradient, RegionalField


def in_world(effect, state):
    label = effect.apply(state, state.field_nT, np.random.default_rng(0), {})
    return np.einsum("nij,nj->ni", state.R_wb, label)


def test_an_error_of_the_given_field_is_one_vector_in_the_world(states):
    state = states(500)
    effect = RegionalField((150, -80, 60))
    np.testing.assert_allclose(in_world(effect, state), np.tile([150.0, -80, 60], (500, 1)), atol=1e-10)
    label = effect.apply(state, state.field_nT, np.random.default_rng(0), {})
    right = state.field_enu_nT + np.array([150, -80, 60])
    np.testing.assert_allclose(state.field_nT + label, np.einsum("nij,i->nj", state.R_wb, right), atol=1e-9)


def test_diurnal_drift_is_a_sine_in_the_world_that_starts_at_zero(states):
    state = states(3000, 1.0)
    world = in_world(DiurnalDrift((10, 0, -5), period_s=3000, phase_deg=30), state)
    course = np.sin(2 * np.pi * state.time_s / 3000 + np.pi / 6) - 0.5
    np.testing.assert_allclose(world, course[:, None] * [10, 0, -5], atol=1e-11)
    assert not world[0].any()


def test_the_day_may_be_counted_from_another_time(states):
    """A wave that is not zero at the start differs by a vector of the world, which is a convention."""
    state, effect = states(3000, 1.0), DiurnalDrift((10, 0, -5), period_s=3000, phase_deg=30)
    wave = np.sin(2 * np.pi * state.time_s / 3000 + np.pi / 6)[:, None] * [10, 0, -5]
    differs = np.einsum("nji,nj->ni", state.R_wb, wave - in_world(effect, state)).ravel()
    columns = effect.convention_columns(state, state.field_nT).reshape(-1, 3)
    assert np.abs(differs).max() > 4
    assert np.abs(differs - columns @ np.linalg.lstsq(columns, differs, rcond=None)[0]).max() < 1e-9


def test_gradient_grows_along_the_way_and_vanishes_at_its_origin(states):
    state = states(400)
    G = np.array([[1.0, 2, 3], [2, -4, 5], [3, 5, 3]])
    origin = state.pos_enu_m[137]
    world = in_world(FieldGradient(G, origin), state)
    np.testing.assert_allclose(world, (state.pos_enu_m - origin) @ G.T, atol=1e-10)
    assert np.abs(world[137]).max() < 1e-12


@pytest.mark.parametrize(
    ("G", "message"),
    [(np.diag([1.0, 1, 1]), "zero sum"), (np.array([[0, 1.0, 0], [0, 0, 0], [0, 0, 0]]), "symmetric")],
)
def test_a_gradient_that_no_static_field_has_is_refused(G, message):
    with pytest.raises(InputError, match=message):
        FieldGradient(G)


def test_attitude_misalignment_leaves_the_magnetometer_alone(states):
    state = states(50)
    assert not in_world(AttitudeMisalignment((1, 2, 3)), state).any()


def test_attitude_misalignment_corrects_a_model_built_on_navigation(states):
    state = states(400)
    effect = AttitudeMisalignment((0.4, -1.1, 2.0))
    R_nav = effect.turn(state.R_wb)
    predicted = np.einsum("nij,i->nj", R_nav, state.field_enu_nT)
    assert np.abs(predicted - state.field_nT).max() > 500
    seen = replace(state, R_wb=R_nav, field_nT=predicted, attitude="navigation")
    corrected = predicted + effect.apply(seen, predicted, np.random.default_rng(0), {})
    np.testing.assert_allclose(corrected, state.field_nT, atol=1e-9)
