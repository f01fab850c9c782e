"""What the values show by themselves: rounding, full scale, held and wrong values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.direct import _spike_law, direct_evidence, held_rows
from diagnosis.policy import STANDARD, Policy
from recordings import Recording
from sim.effects.base import Effect
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts, Spikes
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, problem, recording, without_attitude
from validation.signals.faults import spikes

FAULTS: dict[type[Effect], dict[str, Any]] = {
    Quantisation: {"step_nT": 4.0},
    Saturation: {"full_scale_nT": 30_000.0},
    Dropouts: {"rate_hz": 0.02, "mean_duration_s": 4.0},
    Spikes: {"rate_hz": 0.1, "amplitude_nT": 300.0},
}


@pytest.mark.parametrize("effect", FAULTS, ids=lambda e: e.name)
def test_a_fault_is_seen_with_its_size(effect: type[Effect]) -> None:
    posed = problem(hidden={effect.name: FAULTS[effect]}, n=8000)
    (found,) = direct_evidence(posed)
    assert type(found.effect) is effect
    for name, value in FAULTS[effect].items():
        assert getattr(found.effect, name) == pytest.approx(value, rel=0.5 if effect in (Dropouts, Spikes) else 0.01)


def test_a_clock_that_errs_now_and_then_makes_no_wrong_values() -> None:
    """The attitude of another moment turns the field: what it leaves lies across the field alone."""
    given, rng = recording(8000), np.random.default_rng(6)
    assert given.att_q is not None
    late = np.repeat(rng.random(4000) < 0.01, 2)
    posed = problem(replace(given, att_q=given.att_q[np.maximum(np.arange(8000) - late, 0)]))
    assert direct_evidence(posed) == []
    assert direct_evidence(replace(posed, policy=Policy(little=1e-6))) != []


def test_the_crests_of_a_wave_are_no_wrong_values() -> None:
    """A wave that is there now and then has no quiet neighbours, one crest of it has high shoulders."""
    given, samples = recording(8000), np.arange(8000)
    for height, period, length in ((8, 9, 60), (12, 14, 7)):
        wave_nT = height * NOISE_NT * np.sin(2 * np.pi * (samples % 400) / period) * (samples % 400 < length)
        share = 1 + wave_nT / np.linalg.norm(given.mag_nT, axis=1)
        assert direct_evidence(problem(replace(given, mag_nT=given.mag_nT * share[:, None]))) == []


def _rounded(model: tuple[Effect, ...] = (), policy: Policy = STANDARD):  # type: ignore[no-untyped-def]
    given = recording()
    return problem(replace(given, mag_nT=4.0 * np.round(given.mag_nT / 4.0)), model, policy)


def test_clean_values_show_nothing() -> None:
    assert direct_evidence(problem()) == []


def test_what_the_model_has_or_the_library_has_not_is_not_found() -> None:
    assert direct_evidence(_rounded((Quantisation(4.0),))) == []
    assert direct_evidence(_rounded((Quantisation(2.0),))) != []
    assert direct_evidence(_rounded(), frozenset({Quantisation.name})) == []


def test_wrong_values_that_the_model_states_are_left_out_and_not_missing() -> None:
    hidden = {Spikes.name: FAULTS[Spikes]}
    (known,) = direct_evidence(problem(hidden=hidden, model=(Spikes(rate_hz=0.1, amplitude_nT=300.0),)))
    (new,) = direct_evidence(problem(hidden=hidden))
    assert known.stated
    assert not new.stated
    assert (known.samples == new.samples).all()


@pytest.mark.parametrize(("rate_hz", "duration_s"), [(0.1, 0.5), (0.5, 0.15), (0.05, 1.5)])
def test_dropouts_are_told_by_their_own_rate_and_length(rate_hz: float, duration_s: float) -> None:
    """Half of the gaps of 0.15 s fall between two samples of 10 Hz, and repeat none."""
    hidden = {Dropouts.name: {"rate_hz": rate_hz, "mean_duration_s": duration_s}}
    (found,) = direct_evidence(problem(hidden=hidden, n=8000, seed=1))
    assert isinstance(found.effect, Dropouts)
    assert found.effect.rate_hz == pytest.approx(rate_hz, rel=0.4)
    assert found.effect.mean_duration_s == pytest.approx(duration_s, rel=0.4)


def test_rows_that_a_slower_sensor_repeats_are_no_dropouts() -> None:
    """Every sixth row repeats the one before: a sensor of 10 Hz, logged at 12."""
    given = recording()
    mag_nT = given.mag_nT.copy()
    mag_nT[5::6] = mag_nT[4::6][: len(mag_nT[5::6])]
    assert direct_evidence(problem(replace(given, mag_nT=mag_nT))) == []


@pytest.mark.parametrize(("rate_hz", "amplitude_nT"), [(0.1, 100.0), (0.2, 25.0), (0.1, 16.0)])
def test_spikes_are_told_by_their_own_rate_and_size(rate_hz: float, amplitude_nT: float) -> None:
    """Half of the spikes of 16 nT lie within five times the noise of 2 nT."""
    hidden = {Spikes.name: {"rate_hz": rate_hz, "amplitude_nT": amplitude_nT}}
    (found,) = direct_evidence(problem(hidden=hidden, n=8000, seed=1))
    assert isinstance(found.effect, Spikes)
    assert found.effect.rate_hz == pytest.approx(rate_hz, rel=0.4)
    assert found.effect.amplitude_nT == pytest.approx(amplitude_nT, rel=0.4)


def test_a_number_of_the_policy_changes_what_is_seen() -> None:
    assert direct_evidence(_rounded(policy=Policy(trace=10.0))) == []


def test_wrong_samples_are_those_that_were_made_wrong() -> None:
    given = recording()
    mag = given.mag_nT.copy()
    where = np.array([300, 1200, 1900, 2800, 3500])
    mag[where, 1] += [200.0, -150.0, 300.0, 180.0, -220.0]
    (found,) = direct_evidence(problem(replace(given, mag_nT=mag)))
    assert found.samples[where].all()
    assert np.count_nonzero(found.samples) <= len(where) + 2


def test_a_body_beside_the_path_is_no_wrong_value_though_others_are() -> None:
    """Its field rises and falls over a hundred samples, far above the noise, between a few single wrong values."""
    given = recording()
    mag, where = given.mag_nT.copy(), np.array([300, 1200, 2800, 3500])
    mag[where, 1] += [200.0, -150.0, 180.0, -220.0]
    passing = 400.0 / (1 + ((np.arange(len(mag)) - 2000) / 30.0) ** 2) ** 1.5
    mag += passing[:, None] * [1.0, -0.6, 0.3]
    (found,) = direct_evidence(problem(replace(given, mag_nT=mag)))
    assert found.samples[where].all()
    assert np.count_nonzero(found.samples) < 20  # of 150 that are far from the iron


def test_rows_that_a_slower_sensor_repeats_are_no_measurements() -> None:
    given = recording()
    slower = np.repeat(given.mag_nT[::2], 2, axis=0)[: len(given)]
    held = held_rows(problem(replace(given, mag_nT=slower)))
    assert held.mean() == pytest.approx(0.5, abs=0.01)
    assert not held[::2].any()
    assert not held_rows(problem(given)).any()


def test_rows_that_rounding_repeats_are_measurements() -> None:
    still = recording()
    rounded = np.round((still.mag_nT[:1] + np.random.default_rng(0).normal(size=(len(still), 3))) / 4.0) * 4.0
    att = np.tile(still.att_q[:1], (len(still), 1))  # type: ignore[index]
    assert not held_rows(problem(replace(still, mag_nT=rounded, att_q=att))).any()


@pytest.mark.parametrize("attitude", [True, False])
def test_held_rows_are_no_noise(attitude: bool) -> None:
    """In a field that turns by 50 nT a sample a held row is off by as much: that is no noise of the sensor."""
    given = recording()
    again = np.random.default_rng(3).random(len(given)) < 1 / 3
    last = np.maximum.accumulate(np.where(again, 0, np.arange(len(given))))
    slower = replace(given, mag_nT=given.mag_nT[last])
    posed = problem(slower if attitude else without_attitude(slower))
    assert posed.sigma_nT == pytest.approx(NOISE_NT, rel=0.08)
    assert held_rows(posed).mean() == pytest.approx(1 / 3, abs=0.02)


@pytest.mark.parametrize("seed", [28, 33, 58])
def test_turns_between_samples_far_apart_are_no_spikes(seed: int) -> None:
    """Every 15 s, irregularly, in a swinging motion, of which only the field's strength is known."""
    rng = np.random.default_rng(100 + seed)
    time_s = np.cumsum(rng.uniform(8.0, 22.0, 2500))
    f_hz, phase = rng.uniform(4e-4, 2e-3, (3, 6)), rng.uniform(0.0, 6.28, (3, 6))
    waves = np.sin(2 * np.pi * f_hz * time_s[:, None, None] + phase).sum(axis=2)
    swing = Rotation.from_euler("ZYX", waves * [0.9, 0.2, 0.26] + time_s[:, None] * [1.6e-3, 0.0, 0.0])
    mag_nT = swing.inv().apply(FIELD_ENU_NT) + 2 * NOISE_NT * rng.normal(size=(len(time_s), 3))
    assert np.count_nonzero(spikes(mag_nT)) >= STANDARD.least_spikes  # as the values stand
    assert direct_evidence(problem(Recording(time_s=time_s, mag_nT=mag_nT))) == []


def test_rows_that_are_left_out_hold_no_spikes() -> None:
    spiked = problem(hidden={Spikes.name: FAULTS[Spikes]})
    (found,) = direct_evidence(spiked)
    assert direct_evidence(spiked.without(found.samples)) == []


def test_a_spike_is_seen_in_the_strength_too() -> None:
    given = without_attitude(recording())
    mag = given.mag_nT.copy()
    where = np.array([300, 1200, 1900, 2800, 3500])
    mag[where] += np.outer([200.0, -150.0, 300.0, 180.0, -220.0], np.ones(3))
    (found,) = direct_evidence(problem(replace(given, mag_nT=mag)))
    assert found.effect.name == Spikes.name
    assert found.samples[where].sum() >= 4


@pytest.mark.parametrize(("step_sigma", "found"), [(0.04, False), (0.06, True)])
def test_rounding_that_is_small_beside_the_noise_is_of_no_account(step_sigma: float, found: bool) -> None:
    given, step_nT = recording(), step_sigma * NOISE_NT
    assert bool(direct_evidence(problem(replace(given, mag_nT=step_nT * np.round(given.mag_nT / step_nT))))) is found


@pytest.mark.parametrize(("off", "found"), [(0.005, False), (0.02, True)])
def test_a_step_is_the_models_within_a_hundredth_and_a_full_scale_within_a_tenth_of_that(
    off: float, found: bool
) -> None:
    assert bool(direct_evidence(_rounded((Quantisation(4.0 * (1 + off)),)))) is found
    full_nT = FAULTS[Saturation]["full_scale_nT"]
    clipped = recording(hidden={Saturation.name: FAULTS[Saturation]})
    model = (Saturation(full_nT * (1 + off / 10)),)
    missing = [one for one in direct_evidence(problem(clipped, model)) if not one.stated]
    assert any(isinstance(one.effect, Saturation) for one in missing) is found


@pytest.mark.parametrize(("above", "mean"), [(0.2, 100.0), (0.3, 30.0)])
def test_wrong_values_of_nearly_one_size_are_all_that_there_are(above: float, mean: float) -> None:
    """Of a hundred in the mean, so much of it above the least."""
    size_nT = 100.0 * (1 + above * np.linspace(-1.0, 1.0, 101))
    rate_hz, mean_nT = _spike_law(size_nT, 101.0, STANDARD.quarter)
    assert mean_nT == pytest.approx(mean)
    assert (rate_hz == 1.0) is (mean == 100.0)


@pytest.mark.parametrize(("share", "across"), [(0.08, True), (0.12, False)])
def test_what_is_off_across_the_field_alone_is_an_error_of_the_attitude(share: float, across: bool) -> None:
    """But for a tenth of it."""
    posed = problem(n=1000)
    samples = np.arange(1000) % 100 == 50
    along = posed.direction
    side = np.cross(along, [0.3, -0.5, 0.8])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    off_nT = samples[:, None] * 300.0 * (share * along + np.sqrt(1 - share**2) * side)
    given = replace(posed.recording, mag_nT=posed.recording.mag_nT + off_nT @ posed.turn.T)
    assert (direct_evidence(problem(given)) == []) is across


@pytest.mark.parametrize(("beside", "seen"), [(2, False), (3, True)])
def test_two_samples_beside_a_repeated_one_are_no_wrong_values(beside: int, seen: bool) -> None:
    given, repeats = recording(), np.arange(300, 3600, 400)
    mag_nT = given.mag_nT.copy()
    mag_nT[repeats] = mag_nT[repeats - 1]
    mag_nT[repeats + beside, 0] += 60 * NOISE_NT
    assert (Spikes.name in [one.effect.name for one in direct_evidence(problem(replace(given, mag_nT=mag_nT)))]) is seen


def test_wrong_values_beside_samples_that_are_left_out_keep_a_law_of_their_own() -> None:
    """Where no peak of the residual is far enough, the values that stand out by themselves are counted."""
    given = recording()
    mag_nT = given.mag_nT.copy()
    mag_nT[[300, 1200, 1900, 2800, 3500], 0] += 20 * NOISE_NT
    (found,) = direct_evidence(problem(replace(given, mag_nT=mag_nT), policy=Policy(never_sigma=1e3)))
    assert isinstance(found.effect, Spikes)
    assert found.effect.rate_hz == pytest.approx(5 / 400, rel=0.5)
