"""Effects of the vehicle: iron, eddy currents, supply currents."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import mu_0 as MU_0

from recordings.channels import TEMPERATURE, currents_of
from scenarios.errors import InputError
from sim.effects.currents import CurrentRipple, EddyCurrent, MotorCurrent
from sim.effects.iron import HardIron, HardIronDrift, SoftIron

B = ((0.1, 0.02, 0.03), (0.04, 0.05, 0.06), (0.07, 0.08, 0.09))


def label_of(effect, state):
    return effect.apply(state, state.field_nT, np.random.default_rng(0), {})


def test_soft_iron_follows_the_signal_and_hard_iron_does_not(states):
    state = states(200)
    np.testing.assert_allclose(label_of(SoftIron(B), state), state.field_nT @ np.array(B).T, rtol=1e-12)
    assert (label_of(HardIron((1, 2, 3)), state) == [1, 2, 3]).all()


def test_drift_is_linear_or_settles(states):
    state = states(3600, 1.0)
    linear = label_of(HardIronDrift((3600, 0, -7200)), state)
    np.testing.assert_allclose(linear[:, 0], state.time_s)
    np.testing.assert_allclose(linear[:, 2], -2 * state.time_s)
    settling = label_of(HardIronDrift((3600, 0, 0), time_constant_s=200), state)[:, 0]
    np.testing.assert_allclose(settling[-1], 200, rtol=1e-6)
    np.testing.assert_allclose(np.gradient(settling, 1.0)[1], np.exp(-1 / 200), rtol=1e-4)


def test_eddy_current_is_the_matrix_times_the_fields_rate(states):
    state = states(500, 0.01)
    rate = np.gradient(state.field_nT, 0.01, axis=0)[2:-2]
    np.testing.assert_allclose(label_of(EddyCurrent(B), state)[2:-2], rate @ np.array(B).T, rtol=1e-3, atol=0.5)


def test_eddy_current_with_inductance_lags_as_a_first_order_system(states):
    tau, w, h = 0.4, 3.0, 0.002
    state = states(20_000, h)
    rate = np.zeros((20_000, 3))
    rate[:, 0] = np.sin(w * state.time_s)
    label = label_of(EddyCurrent(B, tau), replace(state, field_rate_nT_s=rate))[:, 0]
    expected = 0.1 / np.hypot(1, w * tau) * np.sin(w * state.time_s - np.arctan(w * tau))
    np.testing.assert_allclose(label[5000:], expected[5000:], atol=1e-6)


@pytest.mark.parametrize("lasts_s", [MU_0 * 5.8e7 * 0.25**2 / np.pi**2, MU_0 * 3.5e7 * 1.5 * 0.01 / 3])
def test_the_bounds_of_an_eddy_current_hold_what_a_vehicle_carries_and_no_more(lasts_s):
    """A ball of copper, diameter 0.5 m, and a hull of aluminium, radius 1.5 m, 10 mm: they undo the field's change."""
    matrix = next(p for p in EddyCurrent.parameters() if p.name == "matrix_s")
    assert lasts_s < matrix.high < 5 * lasts_s
    assert matrix.low == -matrix.high


def test_motor_current_takes_one_motor_or_all(states):
    state = states(100)
    one = label_of(MotorCurrent((1, 0, -2), motor=2), state)
    np.testing.assert_allclose(one[:, 0], state.current_A[:, 1])
    np.testing.assert_allclose(one[:, 2], -2 * state.current_A[:, 1])
    np.testing.assert_allclose(label_of(MotorCurrent((1, 0, 0)), state)[:, 0], state.current_A.sum(axis=1))


def test_a_motor_that_is_not_there_is_refused(states):
    with pytest.raises(InputError, match="motor 4 asked for, there are 1, 2, 3"):
        label_of(MotorCurrent((1, 1, 1), motor=4), states(10))


def test_a_motor_keeps_its_number_where_others_are_missing(states):
    state = states(20)
    named = {"current_10_A": state.time_s, "current_2_A": 2 + state.time_s}
    gapped = replace(state, channels=named)
    np.testing.assert_array_equal(label_of(MotorCurrent((1, 0, 0), motor=10), gapped)[:, 0], state.time_s)
    np.testing.assert_allclose(label_of(MotorCurrent((1, 0, 0)), gapped)[:, 0], 2 + 2 * state.time_s)
    with pytest.raises(InputError, match="motor 1 asked for, there are 2, 10"):
        label_of(MotorCurrent((1, 0, 0), motor=1), gapped)


def test_ripple_is_a_tone_on_the_current(states):
    state = replace(states(5000, 0.01), channels=currents_of(np.full((5000, 1), 4.0)))
    label = label_of(CurrentRipple((2, 0, 0), frequency_hz=10, phase_deg=90), state)[:, 0]
    spectrum = np.abs(np.fft.rfft(label)) / 2500
    assert np.fft.rfftfreq(5000, 0.01)[spectrum.argmax()] == pytest.approx(10)
    assert spectrum.max() == pytest.approx(8.0)
    assert label[0] == pytest.approx(8.0)


def test_a_channel_that_nobody_gives_is_refused_with_those_there_are(states):
    bare = replace(states(50), channels={TEMPERATURE: np.zeros(50)})
    for effect in (MotorCurrent((1, 0, 0)), CurrentRipple((1, 0, 0))):
        with pytest.raises(InputError, match=r"'current_1_A'.*the channels are temperature_degC"):
            label_of(effect, bare)


def test_a_bent_line_adds_to_a_motors_field(states):
    state = states(300)
    state = replace(state, channels=state.channels | currents_of(np.linspace(-2, 3, 300)[:, None] * [1.0, -0.5]))
    one = state.channels["current_1_A"]
    effect = MotorCurrent((1, 2, 3), motor=1, square_nT_A2=(0, 0, 0.5), cube_nT_A3=(0.1, 0, 0))
    expected = np.stack([one + 0.1 * one**3, 2 * one, 3 * one + 0.5 * one * np.abs(one)], axis=1)
    np.testing.assert_allclose(label_of(effect, state), expected, atol=1e-12)


def test_harmonics_go_with_the_ripple_and_its_drift(states):
    state = states(500)
    effect = CurrentRipple(
        (1, 2, 3), 5.0, 30.0, 1, drift_hz_s=0.2, second_sine_nT_A=(0, 0.3, 0), third_cosine_nT_A=(0, 0, 0.2)
    )
    rate_hz = 5.0 + 0.2 * (state.time_s[1:] + state.time_s[:-1]) / 2
    theta = 2 * np.pi * np.append(0.0, np.cumsum(rate_hz * state.interval_s))
    expected = np.sin(theta + np.radians(30))[:, None] * [1.0, 2.0, 3.0]
    expected += np.stack([0 * theta, 0.3 * np.sin(2 * theta), 0.2 * np.cos(3 * theta)], axis=1)
    current = state.channels["current_1_A"][:, None]
    np.testing.assert_allclose(label_of(effect, state), current * expected, atol=1e-9)
