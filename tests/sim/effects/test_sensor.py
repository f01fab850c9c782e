"""Effects of the sensor that draw no random numbers: geometry, curvature, memory, temperature, bandwidth, offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from recordings.channels import TEMPERATURE
from sim.effects.dynamics import Bandwidth
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.nonlinearity import Hysteresis, Nonlinearity
from sim.effects.offsets import OffsetJump
from sim.effects.rotation import axes_and_turn, rotation, rotation_angles_deg, triangular_angles_deg
from sim.effects.temperature import TemperatureOffset, TemperatureScale


def label_of(effect, state, signal=None):
    signal = state.field_nT if signal is None else signal
    return effect.apply(state, signal, np.random.default_rng(0), {})


def test_misalignment_keeps_the_norm_and_turns_by_its_angles(states):
    state = states(100)
    out = state.field_nT + label_of(Misalignment((1, -2, 3)), state)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), np.linalg.norm(state.field_nT, axis=1))
    quarter = Misalignment((0, 0, 90)).matrix() @ [1, 0, 0]
    np.testing.assert_allclose(quarter, [0, 1, 0], atol=1e-15)


def test_zhangs_matrix_is_symmetric_and_a_rotation_only_in_neither_case(states):
    M = Misalignment((1.2, -1.4, 0.3), form="zhang2018").matrix()
    assert (M == M.T).all()
    assert np.abs(M @ M.T - np.eye(3)).max() > 1e-3


def test_leaning_axes_have_length_one_and_lean_by_their_angles():
    N = NonOrthogonality((2.0, 3.0, -1.0)).matrix()
    np.testing.assert_allclose(np.linalg.norm(N, axis=1), 1.0)
    assert np.degrees(np.arcsin(N[0, 1])) == pytest.approx(2.0)
    assert np.degrees(np.arcsin(N[1, 2])) == pytest.approx(-1.0)
    np.testing.assert_allclose(triangular_angles_deg(N), (2.0, 3.0, -1.0))


def test_any_matrix_is_leaning_axes_after_a_turn():
    rng = np.random.default_rng(3)
    for _ in range(50):
        A = rng.normal(size=(3, 3))
        A[0] *= np.sign(np.linalg.det(A))
        N, Q = axes_and_turn(A)
        np.testing.assert_allclose(N @ Q, A, atol=1e-13)
        assert (np.diag(N) > 0).all()
        assert np.linalg.det(Q) == pytest.approx(1.0)
        np.testing.assert_allclose(rotation(rotation_angles_deg(Q)), Q, atol=1e-13)


@pytest.mark.parametrize("pitch", [90.0, -90.0])
def test_angles_come_back_at_the_poles(pitch):
    R = rotation((30.0, pitch, 50.0))
    np.testing.assert_allclose(rotation(rotation_angles_deg(R)), R, atol=1e-12)


@pytest.mark.parametrize("sine", [-1.0, 1.0])
def test_rounding_beyond_a_right_angle_is_one(sine):
    R = np.array([[0.0, 0.0, sine], [0.0, 1.0, 0.0], [-np.nextafter(sine, 2 * sine), 0.0, 0.0]])
    assert rotation_angles_deg(R) == pytest.approx((0.0, 90.0 * sine, 0.0))


def test_scale_is_a_factor_on_each_axis(states):
    state = states(50)
    out = state.field_nT + label_of(Scale((0.1, 0.0, -0.2)), state)
    np.testing.assert_allclose(out, state.field_nT * [1.1, 1.0, 0.8])


def test_nonlinearity_has_its_size_at_the_reference_and_its_symmetry(states):
    state = states(2)
    signal = np.array([[50_000.0] * 3, [-50_000.0] * 3])
    label = label_of(Nonlinearity((1e-3, 0, 1e-3), (0, 2e-3, 2e-3)), state, signal)
    np.testing.assert_allclose(label, [[50, 100, 150], [50, -100, -50]])


def test_a_sensor_that_warms_late_follows_a_ramp_of_temperature_by_its_lag(states):
    state = replace(states(2000), channels={TEMPERATURE: 20 + 0.01 * np.arange(2000) * states(2000).interval_s})
    late = label_of(TemperatureOffset((1, 2, 3), reference_degC=20.0, lag_s=5.0), state)
    settled = state.time_s - state.time_s[0] > 50
    np.testing.assert_allclose(late[settled], 0.01 * (state.time_s - state.time_s[0] - 5)[settled, None] * [1, 2, 3])
    scaled = label_of(TemperatureScale((1e-3, 1e-3, 1e-3), reference_degC=20.0, lag_s=5.0), state)
    np.testing.assert_allclose(scaled, 1e-3 * state.field_nT * late[:, :1])


def test_temperature_acts_on_offset_and_on_sensitivity(states):
    state = states(200)
    warm = state.channel(TEMPERATURE) - 15
    np.testing.assert_allclose(label_of(TemperatureOffset((1, 0, 2), 15), state)[:, 2], 2 * warm)
    scaled = label_of(TemperatureScale((1e-4, 0, 0), 15), state)
    np.testing.assert_allclose(scaled[:, 0], 1e-4 * warm * state.field_nT[:, 0])


def loop(effect, states, cycles, amplitude=20_000.0):
    n = 2000 * cycles
    signal = np.zeros((n, 3))
    signal[:, 0] = amplitude * np.sin(2 * np.pi * np.arange(n) / 2000)
    return signal[:, 0], label_of(effect, states(n), signal)[:, 0]


@pytest.mark.parametrize("threshold", [500.0, (200.0, 500.0, 3000.0)])
def test_hysteresis_closes_its_loop_and_stays_within_its_bound(states, threshold):
    signal, label = loop(Hysteresis(0.1, threshold), states, 4)
    assert np.abs(label).max() <= 0.1 * np.mean(threshold) + 1e-9
    np.testing.assert_allclose(label[4000:6000], label[6000:], atol=1e-9)
    rising, falling = label[6000 + 1999], label[6000 + 1000]
    assert abs(signal[6000 + 1000]) < 1e-6
    assert rising == pytest.approx(-0.1 * np.mean(threshold), rel=1e-6)
    assert falling == pytest.approx(0.1 * np.mean(threshold), rel=1e-6)


def test_the_area_of_a_hysteresis_loop_is_the_plays(states):
    """Once round, a play of half-width r on a swing A encloses 2 r (2 A - 2 r)."""
    r, A = 500.0, 20_000.0
    signal, label = loop(Hysteresis(1.0, r), states, 3)
    x, y = signal[2000:4001], label[2000:4001]
    area = abs(np.sum((y[1:] + y[:-1]) / 2 * np.diff(x)))
    assert area == pytest.approx(2 * r * (2 * A - 2 * r), rel=0.01)


def test_a_swing_within_the_play_leaves_no_loop(states):
    signal, label = loop(Hysteresis(0.1, 500.0), states, 2, amplitude=200.0)
    np.testing.assert_allclose(label, -0.1 * signal, atol=1e-9)


def test_plays_add_up(states):
    _, both = loop(Hysteresis(0.1, 500.0, second_gain=0.2, second_threshold_nT=3000.0), states, 2)
    _, one = loop(Hysteresis(0.1, 500.0), states, 2)
    _, other = loop(Hysteresis(0.2, 3000.0), states, 2)
    np.testing.assert_allclose(both, one + other, atol=1e-9)
    assert np.abs(both).max() == pytest.approx(0.1 * 500 + 0.2 * 3000)


def test_a_rounded_loop_falls_off_to_its_branch_and_gives_the_area_of_an_exponential(states):
    """From a turn at -A on ``D = r - (r + D_0) exp(-(s + A) / r)``; once round a wide swing encloses 4 r A - 4 r^2."""
    r, A = 500.0, 20_000.0
    signal, label = loop(Hysteresis(rounded_gain=1.0, rounded_threshold_nT=r), states, 3)
    rising = slice(3500, 4500)
    expected = -(r - 2 * r * np.exp(-(signal[rising] + A) / r))
    np.testing.assert_allclose(label[rising], expected, atol=1e-3 * r)
    x, y = signal[2000:4001], label[2000:4001]
    assert abs(np.sum((y[1:] + y[:-1]) / 2 * np.diff(x))) == pytest.approx(4 * r * A - 4 * r**2, rel=0.01)


def test_what_was_there_before_the_run_falls_off_with_the_way_of_the_signal(states):
    """``b exp(-w / r)``: after a sweep of 4 A the way is 4 A, whatever the signal is then."""
    A, r = 20_000.0, 15_000.0
    effect = Hysteresis(rounded_start_nT=(50.0, -20.0, 30.0), rounded_threshold_nT=r)
    _, label = loop(effect, states, 1, A)
    assert label[0] == pytest.approx(50.0)
    assert label[500] == pytest.approx(50.0 * np.exp(-A / r))
    assert label[-1] == pytest.approx(50.0 * np.exp(-4 * A / r), rel=1e-2)


def test_a_kink_is_half_of_the_difference_of_the_slopes(states):
    state = states(10)
    signal = np.linspace(-5e4, 5e4, 10)[:, None] * np.ones(3)
    label = label_of(Nonlinearity(kink=(0.01, 0.0, -0.02)), state, signal)
    np.testing.assert_allclose(label, np.abs(signal) * [0.01, 0.0, -0.02])


def test_two_lags_follow_one_another(states):
    """A step of T through lags a and b: ``1 - (a exp(-t/a) - b exp(-t/b)) / (a - b)``."""
    a, b = 8.0, 3.0
    state = states(4000, 0.02)
    T = np.where(state.time_s > 0.01, 30.0, 20.0)
    state = replace(state, channels=state.channels | {TEMPERATURE: T})
    label = label_of(TemperatureOffset((1.0, 0.0, 0.0), lag_s=a, second_lag_s=b), state, state.field_nT)[:, 0]
    t = state.time_s
    np.testing.assert_allclose(label, 10 * (1 - (a * np.exp(-t / a) - b * np.exp(-t / b)) / (a - b)), atol=0.03)


@pytest.mark.parametrize("cutoff", [0.5, 2.0, 20.0])
def test_bandwidth_attenuates_and_delays_a_tone(states, cutoff):
    f, h = 1.3, 0.002
    state = states(20_000, h)
    signal = np.repeat(np.sin(2 * np.pi * f * state.time_s)[:, None], 3, axis=1)
    out = signal + label_of(Bandwidth(cutoff), state, signal)
    expected = np.sin(2 * np.pi * f * state.time_s - np.arctan(f / cutoff)) / np.hypot(1, f / cutoff)
    np.testing.assert_allclose(out[10_000:], np.repeat(expected[10_000:, None], 3, axis=1), atol=5e-5)


@pytest.mark.parametrize("cutoff", [1e-2, 1.0, 1e2, 1e4, 1e6])
def test_bandwidth_delays_a_ramp_by_its_time_constant_at_any_sample_rate(states, cutoff):
    delay = 1 / (2 * np.pi * cutoff)
    n = 5000 if cutoff >= 1 else 20_000
    state = states(n, 0.02)
    label = label_of(Bandwidth(cutoff), state, np.repeat(state.time_s[:, None], 3, axis=1))
    np.testing.assert_allclose(label[-1], -delay, rtol=1e-6, atol=1e-13)


@pytest.mark.parametrize("part", [1e-3, 0.3, 10.0])
def test_a_low_pass_at_few_samples_is_that_of_the_curve_between_them(states, part):
    turn = 0.15  # of a radian from sample to sample: lines between them would be off by half of it
    state = states(2000, 0.1)
    angle, lag = turn * np.arange(2000), part * turn
    signal = np.repeat(np.sin(angle)[:, None], 3, axis=1)
    label = label_of(Bandwidth(1 / (2 * np.pi * part * 0.1)), state, signal)[:, 0]
    expected = np.sin(angle - np.arctan(lag)) / np.hypot(1, lag) - np.sin(angle)
    assert np.linalg.norm((label - expected)[500:]) < 0.01 * np.linalg.norm(expected[500:])


def test_a_constant_passes_the_low_pass_from_the_first_sample(states):
    signal = np.tile([1e4, -2e4, 3e4], (100, 1))
    assert np.abs(label_of(Bandwidth(0.1), states(100), signal)).max() < 1e-9


def test_offset_jumps_at_its_time(states):
    label = label_of(OffsetJump(1.0, (5, 0, -3)), replace(states(100), time_s=np.arange(100) * 0.02))
    assert not label[:50].any()
    assert (label[50:] == [5, 0, -3]).all()


@pytest.mark.parametrize("effect", [TemperatureOffset((2, -3, 1)), TemperatureScale((1e-4, 2e-4, -1e-4))])
def test_another_reference_temperature_is_a_convention(effect, states):
    """Counted from a temperature 7 degrees higher it differs by -7 of its one convention."""
    state = states(50)
    higher = replace(effect, reference_degC=effect.reference_degC + 7)
    change = label_of(higher, state) - label_of(effect, state)
    np.testing.assert_allclose(change, -7 * effect.convention_columns(state, state.field_nT)[:, :, 0], atol=1e-9)


def test_a_bend_may_be_counted_from_another_slope_and_another_zero(states):
    """A cubic less its tangent at another point is within its conventions and its own forms."""
    state = states(200)
    x = state.field_nT[:, 0] / 5e4
    bent = (x - 0.3) ** 3 * 50
    own = Nonlinearity.basis(state, state.field_nT)[:, 0, :]
    columns = np.column_stack([own, Nonlinearity((1e-3, 0, 0)).convention_columns(state, state.field_nT)[:, 0]])
    left = bent - columns @ np.linalg.lstsq(columns, bent, rcond=None)[0]
    assert np.abs(left).max() < 1e-6


def test_a_loop_may_be_counted_from_another_slope_and_another_zero(states):
    """A core of plays that follow the signal, not of stops, and with a remanence, is within both."""
    state, half_width = states(200), 3000.0
    x = state.field_nT[:, 0]
    play = np.empty(200)
    play[0] = x[0]
    for k in range(1, 200):
        play[k] = np.clip(play[k - 1], x[k] - half_width, x[k] + half_width)
    core = 0.01 * play + 25
    loop = Hysteresis((0.01, 0, 0), half_width)
    own = Hysteresis.basis(state, state.field_nT, threshold_nT=half_width)[:, 0, :]
    columns = np.column_stack([own, loop.convention_columns(state, state.field_nT)[:, 0]])
    assert np.abs(core - own @ np.linalg.lstsq(own, core, rcond=None)[0]).max() > 10
    assert np.abs(core - columns @ np.linalg.lstsq(columns, core, rcond=None)[0]).max() < 1e-6


def test_a_temperature_curve_is_counted_from_the_middle_of_the_course(states):
    state = replace(states(300), channels={TEMPERATURE: np.linspace(4.0, 5.0, 300)})
    for effect in (TemperatureOffset, TemperatureScale):
        assert effect.central_reference(state) == {"reference_degC": 4.5}
