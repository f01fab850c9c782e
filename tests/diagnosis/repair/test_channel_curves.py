"""Curves of channels: forms that are no polynomial are followed and foretell another run; false drivers are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import ChannelShare
from diagnosis.library.drivers import CHANNEL_LAGS, find_drivers
from diagnosis.policy import Policy
from diagnosis.problem.formulation import pose, pose_model
from diagnosis.problem.known import Known
from diagnosis.repair.named_effects import CurveRound, better_channels, channel_of, follow_channels, select_curves
from diagnosis.repair.refinement import chain_residual
from diagnosis.result import EvidenceKind
from diagnosis.several.transfer import confirmed
from diagnosis.workflow import diagnose
from recordings import Recording
from recordings.channels import HEIGHT, current_name
from scenarios.arrays import Array
from sim.effects import Effects
from sim.effects.channels import ChannelEffect
from sim.effects.kernels import first_order_lag
from sim.scenario import ModelSpec
from tests.diagnosis.decision.answers import FOUND, case_of
from tests.diagnosis.synthetic import FIELD_ENU_NT, HZ, NOISE_NT, STRENGTH_NT, problem, recording

WAY = np.array([0.6, -1.0, 0.4]) * NOISE_NT
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [NOISE_NT] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)


def load(seed: int, n: int = 4000) -> Array:
    """A load (n,) between -1 and 1 that changes its level now and then."""
    rng = np.random.default_rng([seed, 3])
    levels, switches = rng.uniform(-1, 1, 400), np.cumsum(rng.exponential(12.0, 399))
    return np.asarray(levels[np.searchsorted(switches, np.arange(n) / HZ)])


def slow(seed: int, n: int = 4000) -> Array:
    """A random walk (n,) of range one."""
    walk = np.cumsum(np.random.default_rng([seed, 4]).normal(size=n))
    return np.asarray(walk / np.ptp(walk))


def disturbed(course: Array, seed: int = 0, **channels: Array) -> Recording:
    """A recording with a disturbance of this course (n,), and channels beside those it has."""
    given = recording(len(course), seed=seed)
    return replace(given, mag_nT=given.mag_nT + course[:, None] * WAY, channels={**given.channels, **channels})


def late(x: Array, lag_s: float) -> Array:
    return first_order_lag(x[:, None], lag_s, 1 / HZ, {})[:, 0]


def found(given: Recording) -> list[str]:
    return [channel_of(one) for one in select_curves(Baseline.of(problem(given)))[0]]


def test_a_saturating_load_that_comes_late_is_followed_and_foretells_another_run() -> None:
    first, second = (
        disturbed(2 * np.tanh(3 * late(load(seed), 2.0)), seed, load_A=load(seed), other=slow(seed)) for seed in (1, 2)
    )
    told = diagnose(first, MODEL)
    (one,) = told.named
    assert isinstance(one.effect, ChannelEffect)
    assert (told.verdict, one.kind, one.effect.channel, one.effect.late) == (
        "unknown",
        EvidenceKind.CURVE,
        "load_A",
        "channel",
    )
    assert one.effect.lag_s == pytest.approx(2.0, rel=0.15)
    assert told.gap.explained is not None
    assert told.gap.explained > 0.9
    assert f"a curve of load_A explains {told.gap.explained:.0%}" in told.sentence
    assert any("load_A shows no mechanism" in line for line in told.advice)
    use = np.ones(len(second), bool)
    again = MODEL.model_copy(update={"effects": told.model.effects, "effect_order": told.model.effect_order})
    sizes = []
    for model in (MODEL, again):
        p = pose_model(second, model, None, None)
        sizes.append(float((chain_residual(p, (), use) ** 2).mean()))
    assert (sizes[0] - sizes[1]) / (sizes[0] - 1) > 0.9
    (known,) = confirmed(told, second, MODEL, None, None).named
    assert known.transfer == "transferred"


def test_several_channels_are_joined_and_each_has_the_lowest_order_that_will_do() -> None:
    one, other = load(1), np.sin(np.arange(4000) / 31.0)
    curves, _ = select_curves(Baseline.of(problem(disturbed(2 * one + 1.5 * other**2, a=one, b=other, c=slow(5)))))
    assert {channel_of(c): dict(c.evidence.candidate.nonlinear)["order"] for c in curves} == {"a": 1, "b": 2}


def test_a_lag_of_the_curve_is_told_from_a_lag_of_the_channel() -> None:
    x = np.sin(np.arange(4000) / 17.0)
    ((one,), _) = select_curves(Baseline.of(problem(disturbed(2 * late(x**2, 3.0), x=x))))
    way = dict(one.evidence.candidate.nonlinear)
    assert way["late"] == "curve"
    assert way["lag_s"] == pytest.approx(3.0, rel=0.15)


def test_the_height_drives_also_where_only_the_strength_is_known() -> None:
    given = recording()
    assert given.pos_enu_m is not None
    height = given.pos_enu_m[:, 2]
    pressed = disturbed(12 * np.sqrt(height - height.min()))
    p = pose(replace(pressed, att_q=None), Known(FIELD_ENU_NT, STRENGTH_NT))
    assert p.mode == "strength"
    assert [channel_of(one) for one in select_curves(Baseline.of(p))[0]] == [HEIGHT]


@pytest.mark.parametrize("seed", range(3))
def test_a_slow_rest_goes_with_no_slow_channel(seed: int) -> None:
    courses = {f"walk_{k}": slow(seed + 10 * k) for k in range(1, 4)}
    assert not found(disturbed(15 * slow(seed), seed, **courses, load=load(seed)))


@pytest.mark.parametrize("seed", range(3))
def test_a_channel_that_is_shifted_in_time_drives_nothing(seed: int) -> None:
    assert not found(disturbed(2 * load(seed), seed, load=np.roll(load(seed), 1500)))


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_course_of_time_is_not_a_channels_however_little_is_asked(power: int) -> None:
    course = np.linspace(-1, 1, 4000) ** power
    asks_little = Policy(coloured_nats=1.0)
    assert not select_curves(Baseline.of(problem(disturbed(4 * course, charge=course), policy=asks_little)))[0]


def test_tones_beside_a_current_give_way_to_the_channel_that_makes_them() -> None:
    t = np.arange(4000) / HZ
    x = sum(np.sin(2 * np.pi * t / period) for period in (4.7, 6.1, 8.9)) / 3
    told = diagnose(disturbed(3 * np.tanh(2 * x), load_A=x), MODEL)
    assert [one.effect.required_inputs for one in told.named] == [("load_A",)]
    assert told.verdict == "unknown"


def test_slow_noise_is_named_only_where_no_recorded_channel_makes_it() -> None:
    """A load that wanders makes a gap that wanders too, with the spectrum of a random walk."""
    told, other = (diagnose(disturbed(4 * slow(2), 2, tank_kg=slow(seed)), MODEL) for seed in (2, 12))
    assert [(one.kind, one.effect.required_inputs) for one in told.named] == [(EvidenceKind.CURVE, ("tank_kg",))]
    assert {one.kind for one in other.named} == {EvidenceKind.SPECTRUM}


def test_a_channel_that_resembles_the_motion_is_no_driver() -> None:
    given = problem(recording())
    turning = given.state.rate_rad_s[:, 0] / np.abs(given.state.rate_rad_s[:, 0]).max()
    like = turning + 0.3 * slow(3)
    assert not found(disturbed(3 * turning**2, like=like))
    assert found(disturbed(3 * like**2, like=like)) == ["like"]


def test_another_magnetometer_is_no_cause() -> None:
    course = 2 * load(1)
    assert not found(disturbed(course, scalar_nT=course))


def test_a_named_effect_leaves_no_room_for_a_curve() -> None:
    told = diagnose(recording(hidden={"motor_current": {"gain_nT_A": [4.0, -2.0, 6.0]}}), MODEL)
    assert [one.name for one in told.named] == ["motor_current"]
    assert MODEL.effects == Effects({"white_noise": {"std_nT": [NOISE_NT] * 3}})


@pytest.mark.parametrize(("n", "lag_s"), [(2900, 100.0), (3100, 300.0)])
def test_nothing_is_felt_later_than_the_run_is_long(n: int, lag_s: float) -> None:
    """Of ten samples a second."""
    given = disturbed(900 * late(load(1, n), 300.0), load=load(1, n))
    look = CurveRound.of(Baseline.of(problem(given)))
    (driver,) = [one for one in find_drivers(look.baseline.problem) if one.name == "load"]
    assert look.best_lag(driver, CHANNEL_LAGS)[1].lag_s == lag_s


@pytest.mark.parametrize(
    ("channel", "explained", "instead"),
    [("load", 0.3, True), ("load", 1.0, False), (current_name(1), 0.3, False)],
    ids=["much more", "hardly more", "a name follows it"],
)
def test_curves_stand_for_names_where_they_explain_much_more(channel: str, explained: float, instead: bool) -> None:
    posed = problem(disturbed(3 * np.tanh(2 * load(0)), load=load(0)))
    case = case_of(FOUND, clean=False, explained=explained, problem=posed, where=(ChannelShare(channel, "body", 0.5),))
    found = better_channels(Baseline.of(posed), case)
    assert (found is not None) == instead
    assert not instead or "load" in {cause for one in found.named for cause in one.effect.required_inputs}
    assert better_channels(Baseline.of(posed), case_of(FOUND, clean=False, problem=posed)) is None


def test_the_gap_before_is_that_beside_the_iron_of_the_whole_run() -> None:
    """Iron of the training part alone, which the motion shows less, would leave more, and that is no gap."""
    start = Baseline.of(problem(disturbed(np.abs(load(3)), load_A=load(3))))
    followed = follow_channels(start, case_of(problem=start.problem))
    assert followed is not None
    held_out = start.held_out_samples()
    whole, trained = (float(np.sqrt((start.residual(use)[held_out] ** 2).mean())) for use in (None, ~start.splits[0]))
    assert whole < trained
    assert followed.gap.before_sigma == pytest.approx(whole, rel=1e-3 * (trained / whole - 1))
