"""A curve of a channel: its form, its lag, what it does beyond its ends, and a channel that nobody gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.effects import build
from sim.effects.channels import ChannelEffect, powers
from sim.scenario import load
from sim.simulation import plan

X = "payload_A"


def label_of(effect, state):
    return effect.apply(state, state.field_nT, np.random.default_rng(0), {})


def driven(states, x):
    return replace(states(len(x)), channels={X: np.asarray(x, dtype=float)})


def test_a_curve_is_a_polynomial_of_the_centred_and_scaled_channel(states):
    state = driven(states, [3.0, 5.0, 6.0, 7.0])
    effect = ChannelEffect(X, 5.0, 2.0, linear_nT=(1.0, 0.0, 2.0), square_nT=(0.0, 3.0, 1.0), cube_nT=(8.0, 0.0, 0.0))
    u = np.array([-1.0, 0.0, 0.5, 1.0])
    np.testing.assert_allclose(label_of(effect, state).T, [u + 8 * u**3, 3 * u**2, 2 * u + u**2])


@pytest.mark.parametrize("order", [1, 2, 3])
def test_beyond_its_ends_a_curve_is_straight_and_has_no_corner(order):
    u = np.linspace(-3, 3, 6001)
    curve = powers(u, order)
    slope = np.gradient(curve, u, axis=0)
    assert np.abs(np.diff(slope, axis=0)).max() < 0.01
    np.testing.assert_allclose(slope[u > 1.01], np.arange(1, order + 1) * np.ones((np.sum(u > 1.01), order)))
    np.testing.assert_allclose(np.abs(slope[u < -1.01]), np.abs(slope[u > 1.01])[::-1])


def test_a_lag_shows_a_step_of_the_channel_as_an_exponential(states):
    state = driven(states, np.arange(2000) >= 500)
    late = label_of(ChannelEffect(X, linear_nT=(10.0, 0, 0), lag_s=2.0), state)[:, 0]
    since_s = (np.arange(2000) - 499.5) * state.interval_s
    np.testing.assert_allclose(late[500:], 10 * (1 - np.exp(-since_s[500:] / 2.0)), atol=1e-3)
    assert not late[:500].any()


def test_a_curve_may_come_late_instead_of_its_channel(states):
    x = np.sin(np.arange(3000) / 50)
    state = driven(states, x)
    square = ChannelEffect(X, square_nT=(1.0, 0, 0), lag_s=0.5, late="curve")
    linear = ChannelEffect(X, linear_nT=(1.0, 0, 0), lag_s=0.5)
    of_square = label_of(linear, driven(states, x**2))
    np.testing.assert_allclose(label_of(square, state), of_square)
    assert np.abs(label_of(replace(square, late="channel"), state) - of_square).max() > 0.1


def test_curves_of_several_channels_add_up(states):
    tables = [{"channel": "a", "linear_nT": [1.0, 0, 0]}, {"channel": "b", "square_nT": [0, 2.0, 0]}]
    one, other = build({"channel_effect": tables}, None, "")
    assert (one.required_inputs, other.required_inputs) == (("a",), ("b",))
    state = replace(states(3), channels={"a": np.array([0.0, 0.5, 1.0]), "b": np.array([1.0, 0.5, 0.0])})
    np.testing.assert_allclose((label_of(one, state) + label_of(other, state))[:, :2], [[0, 2], [0.5, 0.5], [1, 0]])


def test_a_channel_that_nobody_gives_is_refused_with_those_there_are(states):
    with pytest.raises(InputError, match="payload_A"):
        label_of(ChannelEffect(X, linear_nT=(1, 0, 0)), states(3))
    scenario = load("auv-spiral", [f'effects.channel_effect={{channel="{X}", linear_nT=[1, 0, 0]}}'])
    with pytest.raises(InputError, match=r"payload_A.*which the auv has not") as refused:
        plan(scenario)
    assert "temperature_degC" in refused.value.do
    plan(load("auv-spiral", ['effects.channel_effect={channel="current_1_A", linear_nT=[1, 0, 0]}']))


@pytest.mark.parametrize("wrong", [5, None, ["temperature_degC"]])
def test_a_channel_is_a_name(wrong):
    with pytest.raises(InputError, match="expected the name of a channel"):
        build({"channel_effect": {"channel": wrong}}, None, "")


def test_a_curve_without_a_channel_is_refused():
    with pytest.raises(InputError, match="no channel"):
        ChannelEffect(cube_nT=(0.0, 0.0, 1.0))
