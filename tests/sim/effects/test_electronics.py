"""Effects of the electronics: delay, clipping, rounding, spikes, gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.effects.dynamics import Latency
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts, Spikes


def out_of(effect, state, signal=None, seed=1):
    signal = state.field_nT if signal is None else signal
    return signal + effect.apply(state, signal, np.random.default_rng(seed), {})


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.013, 0.06, 0.5123])
def test_latency_delays_a_slow_tone(states, delay):
    state = states(3000)
    signal = np.repeat(np.sin(0.3 * state.time_s)[:, None], 3, axis=1)
    out = out_of(Latency(delay), state, signal)[:, 1]
    expected = np.sin(0.3 * (state.time_s - delay))
    late = state.time_s >= delay + state.interval_s  # before that a held value is among the three
    np.testing.assert_allclose(out[late], expected[late], atol=1e-7)
    np.testing.assert_allclose(out[state.time_s < delay - state.interval_s], signal[0, 1], atol=1e-12)


@pytest.mark.parametrize("turn_rad", [0.025, 0.05, 0.1])
def test_the_label_of_a_latency_does_not_depend_on_the_sample_interval(states, turn_rad):
    """Of a field that turns by up to a tenth of a radian in a sample, as a hand-held sensor's does."""
    state = states(2000)
    w, delay = turn_rad / state.interval_s, 0.3 * state.interval_s
    signal = np.repeat(3e4 * np.sin(w * state.time_s)[:, None], 3, axis=1)
    label = Latency(delay).apply(state, signal, np.random.default_rng(0), {})[5:, 0]
    true = 3e4 * (np.sin(w * (state.time_s - delay)) - np.sin(w * state.time_s))[5:]
    assert np.abs(label - true).max() < 0.01 * np.abs(true).max()


def test_saturation_clips_both_ways_and_leaves_the_rest(states):
    state = states(2000)
    out = out_of(Saturation(15_000), state)
    inside = np.abs(state.field_nT) <= 15_000
    assert 0 < inside.mean() < 1
    assert (out[inside] == state.field_nT[inside]).all()
    np.testing.assert_allclose(np.abs(out[~inside]), 15_000)


def test_quantisation_error_is_uniform_and_values_lie_on_the_lattice(states):
    state = states(20_000)
    out = Quantisation(2.5).replace(state, state.field_nT, np.random.default_rng(0), {})
    assert (out == 2.5 * np.round(out / 2.5)).all()
    error = out - state.field_nT
    assert np.abs(error).max() <= 1.25
    assert error.std() == pytest.approx(2.5 / np.sqrt(12), rel=0.02)
    assert np.mean(np.abs(error) < 0.625) == pytest.approx(0.5, abs=0.02)


def test_spikes_come_at_their_rate_on_one_axis_with_their_size(states):
    n, rate, amplitude = 400_000, 0.8, 200.0
    state = replace(states(2), time_s=np.arange(n) * 0.02)
    label = Spikes(rate, amplitude).apply(state, np.zeros((n, 3)), np.random.default_rng(2), {})
    hit = label[label != 0]
    mean = rate * n * 0.02
    assert len(hit) == pytest.approx(mean, abs=4 * np.sqrt(mean))
    assert np.abs(hit).mean() == pytest.approx(amplitude, rel=0.06)
    assert np.mean(hit > 0) == pytest.approx(0.5, abs=0.03)
    assert np.allclose((label != 0).mean(axis=0) * n, mean / 3, atol=5 * np.sqrt(mean / 3))
    gaps = np.diff(np.flatnonzero(label.any(axis=1))) * 0.02
    assert gaps.std() == pytest.approx(gaps.mean(), rel=0.05)


@pytest.mark.parametrize(("rate", "duration"), [(0.5, 0.5), (2.0, 0.05), (0.1, 3.0)])
def test_dropouts_repeat_the_last_value_for_their_share_of_time(states, rate, duration):
    n = 400_000
    state = replace(states(2), time_s=np.arange(n) * 0.02)
    signal = np.random.default_rng(9).normal(size=(n, 3))
    out = Dropouts(rate, duration).replace(state, signal, np.random.default_rng(3), {})
    held = (out != signal).any(axis=1)
    share = duration / (duration + 1 / rate)
    assert held.mean() == pytest.approx(share, rel=0.08)
    assert (out[1:][held[1:]] == out[:-1][held[1:]]).all()


@pytest.mark.parametrize("rate_hz", [5e-324, 1e-310])
def test_an_event_of_the_rarest_kind_never_comes(rate_hz, states):
    """The smallest numbers have no reciprocal."""
    state, signal = states(50), np.ones((50, 3))
    assert not Spikes(rate_hz, 5.0).apply(state, signal, np.random.default_rng(0), {}).any()
    assert (Dropouts(rate_hz, 1.0).replace(state, signal, np.random.default_rng(0), {}) == signal).all()
