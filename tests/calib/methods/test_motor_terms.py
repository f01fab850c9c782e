"""Terms of currents, commands and temperature: found, judged on unseen legs, applied to another flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import Reference, from_json, get, to_json
from calib.input_terms import CURRENT_SUM, delayed
from recordings import Recording
from recordings.assemble import recording_of
from scenarios.errors import InputError
from sim.scenario import load
from sim.simulation import blocks, plan
from tests.nightly import first_daily

GAIN_NT_A, LAG_S = np.array([60.0, -40.0, 90.0]), 0.2
NOISE_NT = 5.0
QUAD = (
    "phases.1.duration_s=100",
    "phases.1.tilt_amplitude_deg=30",
    "sampling.rate_hz=25",
    "effects.eddy_current.matrix_s=[[0,0,0],[0,0,0],[0,0,0]]",
    "effects.current_ripple.amplitude_nT_A=[0,0,0]",
    f"effects.motor_current.gain_nT_A={GAIN_NT_A.tolist()}",
    f"effects.motor_current.lag_s={LAG_S}",
)
METHODS = pytest.mark.parametrize("name", ["motor_ellipsoid", "motor_vector"])


@pytest.fixture
def thrust(standard):
    """A tumbling recording with four independent motor currents (n, 4), smooth over a second, that make no field."""

    def make(seed: int = 0, n: int = 3000) -> Recording:
        rng = np.random.default_rng(seed)
        steps = np.repeat(rng.uniform(2.0, 8.0, (n // 20 + 1, 4)), 20, axis=0)[:n]
        one = standard.recording("full", seed, n=n, noise_std_nT=NOISE_NT)
        current_A = np.column_stack([delayed(column, one.time_s, 1.0) for column in steps.T])
        return replace(one, current_A=current_A)

    return make


def pushed(one: Recording, field_nT: np.ndarray) -> Recording:
    return replace(one, mag_nT=one.mag_nT + field_nT)


def strength_rms(field_nT: np.ndarray, reference: Reference) -> float:
    return float(np.sqrt(np.mean((np.linalg.norm(field_nT, axis=1) - reference.strength_nT) ** 2)))


@METHODS
def test_each_motor_has_its_own_gain(name, thrust, standard):
    gains = np.array([[5.0, -3.0, 8.0], [-6.0, 4.0, 2.0], [7.0, 9.0, -5.0], [0.0, -8.0, 3.0]])
    one, other = thrust(1), thrust(2)
    found = get(name).fit(pushed(one, one.current_A @ gains), standard.REFERENCE)
    assert found.status.kind == "ok"
    assert [term.channel for term in found.inputs] == [f"current_{k}_A" for k in (1, 2, 3, 4)]
    rows = [found.covariance_names.index(key) for term in found.inputs for key in term.names]
    std = np.sqrt(np.diag(found.covariance)[rows]).reshape(4, 3)
    off = (np.stack([term.gain_nT for term in found.inputs]) - gains) / std
    assert np.abs(off).max() < 4.0
    assert np.sqrt(np.mean(off**2)) > 0.4
    unseen = pushed(other, other.current_A @ gains)
    assert strength_rms(found.apply(unseen), standard.REFERENCE) < 1.1 * NOISE_NT


@METHODS
def test_without_a_field_no_term_is_used(name, thrust, standard):
    found = get(name).fit(thrust(3), standard.REFERENCE)
    assert (found.status.kind, found.inputs, found.eddy_s) == ("ok", (), None)
    assert "no current or command changes the field" in found.status.reason


@METHODS
def test_a_current_that_stays_is_unobservable(name, thrust, standard):
    steady = replace(thrust(4), current_A=np.full((3000, 1), 12.0))
    found = get(name).fit(pushed(steady, np.tile(GAIN_NT_A, (3000, 1))), standard.REFERENCE)
    assert found.status.kind == "unobservable"
    assert "current_1_A stays at 12" in found.status.reason
    assert found.inputs == ()


def test_a_current_that_follows_the_attitude_is_unobservable(thrust, standard):
    one, rng = thrust(5), np.random.default_rng(0)
    field_nT = standard.attitude("full", one.time_s).inv().apply(standard.FIELD_ENU_NT)
    current_A = 10.0 + 2.0 * field_nT[:, 2:] / standard.REFERENCE.strength_nT + rng.normal(0.0, 1e-3, (3000, 1))
    followed = replace(one, current_A=current_A)
    found = get("motor_vector").fit(pushed(followed, 5.0 * current_A * [1.0, 1.0, -1.0]), standard.REFERENCE)
    assert found.status.kind == "unobservable"
    assert "current_1_A follows the attitude" in found.status.reason


def test_a_drift_is_not_put_down_to_a_warming_sensor(thrust, standard):
    """A temperature that rises while the offset drifts: so would any slow signal."""
    one = replace(thrust(6), current_A=None)
    rng = np.random.default_rng(2)
    walk = np.cumsum(rng.standard_normal((3000, 3)), axis=0)
    warm = replace(one, temperature_degC=20.0 + 5.0 * one.time_s / one.time_s[-1] + 0.05 * rng.standard_normal(3000))
    found = get("motor_ellipsoid").fit(pushed(warm, walk), standard.REFERENCE)
    assert found.inputs == ()
    assert "the cause may be a drift" in found.status.reason


def test_a_temperature_with_a_lag(thrust, standard):
    one = replace(thrust(7), current_A=None)
    temperature_degC = 20.0 + 8.0 * np.sign(np.sin(2 * np.pi * one.time_s / 100.0))
    slope = np.array([8.0, -12.0, 10.0])
    felt = delayed(temperature_degC, one.time_s, 12.0)
    warm = replace(pushed(one, felt[:, None] * slope), temperature_degC=temperature_degC)
    found = get("motor_ellipsoid").fit(warm, standard.REFERENCE)
    assert found.status.kind == "ok"
    (term,) = found.inputs
    assert term.channel == "temperature_degC"
    assert term.reference == pytest.approx(temperature_degC.mean(), abs=0.1)
    assert term.lag_s == pytest.approx(12.0, rel=0.1)
    np.testing.assert_allclose(term.gain_nT, slope, atol=0.3)


def test_throttle_and_current_that_tell_the_same_are_named(thrust, standard):
    one = thrust(8)
    total = one.current_A.sum(axis=1)
    both = replace(one, channels={"throttle": total / 40.0})
    found = get("motor_ellipsoid").fit(pushed(both, total[:, None] * [3.0, -2.0, 4.0]), standard.REFERENCE)
    noisy = replace(
        both, channels={"throttle": total / 40.0 + 1e-3 * np.random.default_rng(2).standard_normal(len(one))}
    )
    alike = get("motor_ellipsoid").fit(pushed(noisy, total[:, None] * [0.3, -0.2, 0.4]), standard.REFERENCE)
    assert [term.channel for term in found.inputs] == [CURRENT_SUM]
    assert "predicts unseen legs as well as" in alike.status.reason


def test_the_throttle_alone_where_asked(thrust, standard):
    one = thrust(9)
    total = one.current_A.sum(axis=1)
    both = replace(one, channels={"throttle": total / 40.0})
    found = get("motor_ellipsoid:throttle").fit(pushed(both, total[:, None] * [3.0, -2.0, 4.0]), standard.REFERENCE)
    (term,) = found.inputs
    assert (term.channel, term.names[0]) == ("throttle", "throttle_x_nT")
    np.testing.assert_allclose(term.gain_nT, [120.0, -80.0, 160.0], atol=4.0)


@pytest.mark.parametrize("name", first_daily(["motor_ellipsoid", "motor_vector"]))
def test_counts_give_gains_in_counts(name, thrust, standard):
    one = thrust(10)
    felt = pushed(one, one.current_A.sum(axis=1)[:, None] * [5.0, -3.0, 8.0])
    counts = replace(felt, mag_nT=felt.mag_nT / 20.0)
    in_nT, in_counts = (get(name).fit(each, standard.REFERENCE) for each in (felt, counts))
    np.testing.assert_allclose(20.0 * in_counts.inputs[0].gain_nT, in_nT.inputs[0].gain_nT, rtol=1e-6)
    key = in_nT.inputs[0].names[0]
    assert 20.0 * in_counts.parameters[key] == pytest.approx(in_nT.parameters[key], rel=1e-6)
    np.testing.assert_allclose(in_counts.apply(counts), in_nT.apply(felt), atol=1e-4)


def test_the_terms_are_kept_in_the_file_and_need_their_channel(thrust, standard):
    one = thrust(11)
    felt = pushed(one, one.current_A.sum(axis=1)[:, None] * [5.0, -3.0, 8.0])
    found = get("motor_ellipsoid").fit(felt, standard.REFERENCE)
    again = from_json(to_json(found))
    assert to_json(again) == to_json(found)
    np.testing.assert_array_equal(again.apply(felt), found.apply(felt))
    with pytest.raises(InputError, match="current_sum_A"):
        again.apply(replace(felt, current_A=None))


def flight(run: int) -> Recording:
    """A run of the quadrotor's calibration flight, without eddy currents and ripple."""
    parts = list(blocks(plan(load("quad-calibration", QUAD), run)))
    return recording_of({key: np.concatenate([part[key] for part in parts]) for key in parts[0]})


def test_another_flight_of_the_quadrotor_is_left_with_the_noise():
    one, other = flight(0), flight(1)
    reference = Reference.of_vector((-1940.0, 31916.0, -41285.0))
    found = get("motor_ellipsoid").fit(one, reference)
    assert found.status.kind == "ok"
    (term,) = found.inputs
    assert (term.channel, term.lag_s) == (CURRENT_SUM, pytest.approx(LAG_S, rel=0.05))
    np.testing.assert_allclose(term.gain_nT, GAIN_NT_A, atol=1.5)
    without = strength_rms(get("ellipsoid").fit(one, reference).apply(other), reference)
    assert without > 10.0 * NOISE_NT
    assert strength_rms(found.apply(other), reference) < 1.2 * NOISE_NT
    assert found.parameters["held_out_rms_nT"] < 1.1 * NOISE_NT < found.parameters["held_out_rms_without_inputs_nT"]
