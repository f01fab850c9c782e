"""The chain: labels add up, streams are independent, values leave the electronics exact."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sim.chain import Chain, apply_deterministic
from sim.effects import BY_NAME, build
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts
from sim.effects.iron import HardIron
from sim.effects.noise import FlickerNoise, WhiteNoise

chosen = st.lists(st.sampled_from(sorted(BY_NAME)), min_size=1, max_size=12)


def total(state, labels):
    return state.field_nT + sum(labels.values())


@given(chosen, st.integers(0, 2**32), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_field_plus_labels_is_the_measurement_for_any_effects_in_any_order(states, active, names, seed, shuffle):
    tables = {name: [active[name]] * names.count(name) for name in names}
    order = list(tables)
    shuffle.shuffle(order)
    state = states(400, seed=seed % 7)
    mag, labels = Chain(build(tables, order, ""), seed=seed).apply(state)
    assert list(labels) == order
    np.testing.assert_allclose(total(state, labels), mag, rtol=0, atol=1e-6)


def test_all_effects_together_add_up(states, active):
    state = states(20_000)
    mag, labels = Chain(build(active, None, ""), seed=1).apply(state)
    assert len(labels) == len(BY_NAME)
    assert mag.dtype == np.float64
    assert np.abs(total(state, labels) - mag).max() < 1e-9


def test_no_effects_give_the_field_and_do_not_hand_it_out(states):
    state = states(10)
    mag, labels = Chain((), seed=0).apply(state)
    assert (mag == state.field_nT).all()
    assert mag is not state.field_nT
    assert labels == {}


def test_another_effect_leaves_the_others_noise_as_it_is(states, active):
    state = states(500)
    alone = Chain((WhiteNoise(5.0),), seed=7).apply(state)[1]["white_noise"]
    among = Chain(build({**active, "white_noise": {"std_nT": 5}}, None, ""), seed=7).apply(state)[1]["white_noise"]
    assert alone.tobytes() == among.tobytes()


def test_runs_sensors_and_instances_draw_their_own_noise(states):
    state = states(2000)
    series = [
        Chain((WhiteNoise(1.0),), seed=7, run=run, sensor=sensor).apply(state)[0][:, 0] - state.field_nT[:, 0]
        for run, sensor in ((0, 0), (0, 1), (1, 0), (1, 1))
    ]
    correlation = np.corrcoef(series) - np.eye(4)
    assert np.abs(correlation).max() < 4 / np.sqrt(2000)
    both = Chain((WhiteNoise(1.0), WhiteNoise(1.0)), seed=7).apply(state)[1]["white_noise"]
    assert both.std() == pytest.approx(np.sqrt(2), rel=0.05)


def test_effects_of_one_name_share_a_label(states):
    state = states(5)
    mag, labels = Chain((HardIron((1, 2, 3)), HardIron((10, 20, 30))), seed=0).apply(state)
    assert (labels["hard_iron"] == [11, 22, 33]).all()
    np.testing.assert_allclose(mag, state.field_nT + np.array([11, 22, 33]))


def test_what_leaves_the_electronics_is_exact(states):
    """Values on the lattice, at full scale and repeated are found by equality, so not one bit may be off."""
    state = states(20_000)
    effects = (WhiteNoise(50.0), Saturation(20_000), Quantisation(0.7), Dropouts(1.0, 0.3))
    mag, labels = Chain(effects, seed=3).apply(state)
    assert (mag == 0.7 * np.round(mag / 0.7)).all()
    held = (labels["dropouts"][1:] != 0).any(axis=1)
    assert held.any()
    assert (mag[1:][held] == mag[:-1][held]).all()
    clipped, _ = Chain(effects[:2], seed=3).apply(state)
    assert (np.abs(clipped) == 20_000).any()


def test_a_models_prediction_draws_nothing(states):
    state = states(100)
    mag, labels = apply_deterministic((HardIron((1, 2, 3)), WhiteNoise(5.0), FlickerNoise(1.0)), state)
    assert list(labels) == ["hard_iron"]
    np.testing.assert_allclose(mag, state.field_nT + np.array([1, 2, 3]))
