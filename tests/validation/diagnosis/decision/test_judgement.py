"""Every rule of the verdict, every doubt of a name, and every line of advice."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sim.effects import BY_NAME, EFFECTS
from sim.effects.iron import HardIron, SoftIron
from tests.validation.diagnosis.synthetic import problem, recording, without_attitude
from validation.diagnosis.decision import judgement
from validation.diagnosis.decision.judgement import Case, channel_is_left, doubts_of, motion_is_left, verdict_of
from validation.diagnosis.decision.wording import ADVICE, advice_for, sentence_for, words_of
from validation.diagnosis.evidence.battery import Battery
from validation.diagnosis.evidence.localise import Share
from validation.diagnosis.evidence.rising import Rise
from validation.diagnosis.result import Diagnosis, GapSize, How, Named, Reach
from validation.diagnosis.verdict import Verdict

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.sought())
POSED = problem()
GAP = GapSize(20.0, 10.0, 4.0, 2.0, 0.97)
EFFECT = DRIVEN(**{DRIVEN.linear[0]: (1.0, 0.0, 0.0)})
FOUND = Named(EFFECT, (), How.HELD_OUT, 50.0, 1.0)
IRON = Named(HardIron((3.0, 0.0, 0.0)), (), How.IRON, 50.0, 1.0)
SEEN = replace(FOUND, how=How.DIRECT, nats=None)
NOISE = Named(EFFECT, (), How.SPECTRUM, 50.0, 0.0)
FAST = Rise(2.0, 4.0, hides=False)
RISING = replace(FOUND, rivals=("temperature_degC",))
TURN = Named(SoftIron(((0.0, 0.01, 0.0), (-0.01, 0.0, 0.0), (0.0, 0.0, 0.0))), (), How.IRON, 50.0, 1.0)


def _case(*named: Named, clean: bool = True, explained: float | None = 0.97, **changes: Any) -> Case:
    case = Case(POSED, named, clean, replace(GAP, explained=explained), (), np.zeros_like(POSED.target))
    return replace(case, **changes)


def _or(named: Named, *others: str) -> Named:
    return replace(named, alternatives=others)


@pytest.mark.parametrize(
    ("case", "verdict"),
    [
        (_case(), Verdict.NONE),
        (_case(clean=False), Verdict.UNKNOWN),
        (_case(FOUND), Verdict.NAMED),
        (_case(_or(FOUND, "bandwidth")), Verdict.CLASS),
        (_case(FOUND, IRON), Verdict.COMPOSITE),
        (_case(FOUND, clean=False), Verdict.PARTIAL),
        (_case(FOUND, clean=False, explained=0.4), Verdict.PARTIAL),
        (_case(FOUND, clean=False, explained=0.15), Verdict.UNKNOWN),
        (_case(FOUND, clean=False, explained=None), Verdict.UNKNOWN),
        (_case(SEEN, clean=False, explained=None), Verdict.PARTIAL),
        (_case(rise=FAST), Verdict.UNKNOWN),
        (_case(FOUND, explained=0.0, rise=FAST), Verdict.PARTIAL),
        (_case(IRON, explained=None, rise=FAST), Verdict.PARTIAL),
        (_case(IRON), Verdict.NAMED),
        (_case(_or(IRON, "soft_iron")), Verdict.CLASS),
        (_case(_or(IRON, "eddy_current")), Verdict.NOT_OBSERVABLE),
        (_case(RISING, IRON), Verdict.CLASS),
        (_case(NOISE, RISING), Verdict.CLASS),
        (_case(RISING, TURN), Verdict.COMPOSITE),
        (_case(RISING, FOUND), Verdict.COMPOSITE),
        (_case(RISING, RISING), Verdict.COMPOSITE),
        (_case(NOISE), Verdict.NAMED),
        (_case(_or(NOISE, "offset_jump")), Verdict.GENERIC),
    ],
)
def test_rules_in_their_order(case: Case, verdict: Verdict) -> None:
    assert verdict_of(case) is verdict


def _still_driven(share: float) -> Case:
    """A case whose rest goes with the current by some share of its power."""
    current = POSED.state.current_A[:, 0] - POSED.state.current_A[:, 0].mean()
    noise = np.random.default_rng(0).normal(size=POSED.target.shape)
    left = noise * 1e-3 + np.sqrt(share) * (current / current.std())[:, None]
    where = (Share("current_1_A", "body", 0.9),)
    return _case(FOUND, clean=False, explained=0.7, where=where, left=left)


def test_a_name_after_which_the_channel_is_still_there_only_resembles_the_cause() -> None:
    assert channel_is_left(_still_driven(1.0)) == "what is left still goes with current_1_A"
    assert doubts_of(_still_driven(1.0), Verdict.PARTIAL)
    assert channel_is_left(replace(_still_driven(1.0), left=np.random.default_rng(1).normal(size=(4000, 3)))) is None
    assert channel_is_left(replace(_still_driven(1.0), gap=replace(GAP, explained=0.99))) is None
    assert channel_is_left(replace(_still_driven(1.0), where=())) is None


def test_any_channel_but_the_first_must_be_left_well_beyond_time() -> None:
    kept = _still_driven(1.0)
    slow = np.sin(0.02 * POSED.state.time_s)[:, None] * np.ones(3)
    near = replace(kept, gap=replace(GAP, explained=0.0), left=kept.left + 1.7 * slow)
    first, second = Share("rate_x", "body", 0.65), Share("current_1_A", "body", 0.65)
    assert channel_is_left(replace(near, where=(second, first))) == "what is left still goes with current_1_A"
    assert channel_is_left(replace(near, where=(first, second))) is None
    assert channel_is_left(replace(kept, where=(first, second))) == "what is left still goes with current_1_A"
    little = Share("current_1_A", "body", 0.3)  # of the gap goes with it, of what is left much more: it did not lead
    assert channel_is_left(replace(kept, where=(first, little))) is None


def test_what_acts_while_a_motion_is_on_and_leaves_more_of_it_is_a_piece_of_its_course() -> None:
    """A window's constant is a piece of what goes with a rate: not where another leads, or it is on beside."""
    n = len(POSED.target)
    on = (np.arange(n) > 0.3 * n) & (np.arange(n) < 0.7 * n)
    rate = on * (1.0 + 0.2 * np.sin(np.arange(n) / 90.0))
    state = replace(POSED.state, channels={**POSED.state.channels, "rate": rate})
    time_s = POSED.state.time_s
    acts = replace(FOUND, effect=SoftIron(active_s=(time_s[on][0], time_s[on][-1])))
    left = (on * np.sin(np.arange(n) / 90.0))[:, None] * np.ones(3)
    leads = Share("rate", "body", 0.7)
    case = _case(acts, clean=False, problem=replace(POSED, state=state), where=(leads,), left=left)
    assert motion_is_left(case) == "acts while rate is on, and what is left goes with that too"
    assert motion_is_left(case) in doubts_of(case, Verdict.PARTIAL)
    assert motion_is_left(replace(case, where=(Share("pitch", "body", 0.8), leads))) is None
    assert motion_is_left(replace(case, left=0 * left)) is None
    assert motion_is_left(replace(case, named=(FOUND,))) is None
    shorter = replace(acts, effect=SoftIron(active_s=(time_s[on][0], time_s[n // 2])))
    assert motion_is_left(replace(case, named=(shorter,))) is None


def test_what_goes_with_time_as_well_speaks_against_no_name() -> None:
    slow = np.sin(0.02 * POSED.state.time_s)[:, None] * np.ones(3)
    assert channel_is_left(_case(FOUND, explained=0.7, where=(Share("time_s", "body", 0.9),), left=slow)) is None
    current = _still_driven(1.0)
    assert channel_is_left(replace(current, left=current.left + 9 * slow)) is None


def test_a_channel_that_only_rises_speaks_against_no_name() -> None:
    """A supply that sags, and with the load a little more: a slow rest goes with it by chance more than with time."""
    part = POSED.state.time_s / POSED.state.time_s[-1]
    sags = 12 - part - 0.02 * np.sin(90 * part)
    left = np.sin(20 * sags)[:, None] * np.ones(3)
    where = (Share("supply_V", "body", 0.9),)
    case = _case(FOUND, clean=False, explained=0.5, where=where, left=left)
    assert channel_is_left(replace(case, problem=problem(replace(recording(), channels={"supply_V": sags})))) is None
    periodic = np.sin(90 * part)
    driven = replace(recording(), channels={"supply_V": periodic})
    assert channel_is_left(replace(case, problem=problem(driven), left=periodic[:, None] * np.ones(3)))


def test_verdicts_that_leave_nothing_are_not_doubted() -> None:
    assert doubts_of(_still_driven(1.0), Verdict.NAMED) == ()
    assert doubts_of(replace(_still_driven(1.0), gap=replace(GAP, explained=None)), Verdict.PARTIAL) == ()
    noisy = replace(_still_driven(1.0), clean=True, named=(FOUND, NOISE))
    assert doubts_of(noisy, Verdict.COMPOSITE)
    assert all(doubts_of(noisy, verdict) == () for verdict in (Verdict.PARTIAL, Verdict.GENERIC, Verdict.NAMED))


def test_in_a_field_that_turns_too_fast_no_name_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judgement, "turns_too_fast", lambda posed: posed is POSED)
    assert doubts_of(_case(FOUND), Verdict.NAMED) == ("the field turns faster than a vehicle does",)


def test_only_names_that_act_where_something_fast_is_left_are_doubted() -> None:
    """However much of the gap that is: a drift beside a rotor's tone stands, a tone that is a part of it does not."""
    fast = _case(FOUND, explained=0.02, rise=FAST)
    assert doubts_of(fast, Verdict.PARTIAL) == ()
    assert doubts_of(replace(_still_driven(1.0), clean=True, rise=FAST), Verdict.PARTIAL) == ()
    hidden = replace(FAST, hides=True)
    assert "structure between 2 and 4 Hz" in doubts_of(replace(fast, rise=hidden), Verdict.PARTIAL)[0]
    assert doubts_of(_case(IRON, rise=hidden), Verdict.PARTIAL) == ()


def test_names_that_make_the_gap_larger_are_doubted() -> None:
    larger = replace(GAP, after_sigma=1.2 * GAP.before_sigma)
    assert doubts_of(replace(_case(FOUND), gap=larger), Verdict.NAMED)
    assert doubts_of(replace(_case(SEEN), gap=larger), Verdict.NAMED) == ()


def _diagnosis(verdict: Verdict = Verdict.NAMED, *named: Named, **changes: Any) -> Diagnosis:
    tests = Battery({}, (), 0.0, ("means over 5 s",))
    made = Diagnosis(verdict, "", named, (), GAP, (), (), (), (), tests, tests, None, POSED, POSED.target, POSED.target)  # type: ignore[arg-type]
    return replace(made, **changes)


def test_the_sentence_says_cause_size_and_share() -> None:
    told = sentence_for(_diagnosis(Verdict.NAMED, FOUND))
    assert told.startswith(f"Missing in the model: {DRIVEN.name}: {DRIVEN.linear[0]} (1, 0, 0) nT/A, 1 sigma")
    assert "of 19.9 nT of structure in 2.00 nT of noise 97 % is gone" in told
    unknown = sentence_for(_diagnosis(Verdict.UNKNOWN, where=(Share("pump", "body", 0.5),)))
    assert "means over 5 s" in unknown
    assert "it goes with pump" in unknown


def test_nothing_is_advised_where_nothing_was_found() -> None:
    assert advice_for(_diagnosis(Verdict.NONE)) == ()


def _turned(hz: float = 0.005) -> np.ndarray[Any, Any]:
    """A gap across the field, slow if nothing else is said."""
    across = np.cross(POSED.state.field_nT, [0.0, 0.0, 1.0])
    return np.sin(2 * np.pi * hz * POSED.state.time_s)[:, None] * across / np.linalg.norm(across, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (_diagnosis(Verdict.CLASS, _or(FOUND, "bandwidth")), "may also be bandwidth. To tell: "),
        (_diagnosis(Verdict.NAMED, FOUND), "--confirm"),
        (_diagnosis(Verdict.NONE, absorbed=("eddy_current",)), "eddy_current can hardly be told from"),
        (_diagnosis(Verdict.NONE, untested=("motor_current (no current)",)), "want of channels: motor_current"),
        (_diagnosis(Verdict.UNKNOWN, before_nT=_turned()), "suspect navigation's attitude"),
    ],
)
def test_each_finding_has_its_advice(found: Diagnosis, says: str) -> None:
    (line,) = [line for line in advice_for(found) if says in line]
    assert line.endswith(".")


@pytest.mark.parametrize(
    ("left_nT", "clocks"),
    [(10 * _turned(3.0), True), (10 * _turned(3.0)[:, :1] * np.ones(3), False)],
    ids=["across", "in the body"],
)
def test_what_rises_and_turns_the_field_is_of_the_clocks_and_no_wheel(
    left_nT: np.ndarray[Any, Any], clocks: bool
) -> None:
    """Stamps that are off leave an error as fast as the samples, of which the strength has nothing."""
    found = _diagnosis(Verdict.UNKNOWN, rise=Rise(2.0, 5.0, False), before_nT=left_nT, after_nT=left_nT)
    told = " ".join(advice_for(found))
    assert ("time stamps" in told) is clocks
    assert ("a wheel" in told) is not clocks


def test_a_recorded_channel_is_offered_as_an_actuator() -> None:
    given = replace(recording(), channels={"pump": np.ones(4000)})
    found = _diagnosis(Verdict.UNKNOWN, problem=problem(given), where=(Share("pump", "body", 0.5),))
    assert "--actuator pump" in advice_for(found)[0]
    assert "--actuator" not in " ".join(advice_for(replace(found, verdict=Verdict.CLASS)))


def test_a_height_is_offered_as_no_actuator() -> None:
    given = replace(recording(), channels={"altitude_m": np.linspace(0.0, 900.0, 4000), "pump": np.ones(4000)})
    where = (Share("altitude_m", "body", 0.9), Share("pump", "body", 0.5))
    told = " ".join(advice_for(_diagnosis(Verdict.UNKNOWN, problem=problem(given), where=where)))
    assert "--actuator pump" in told
    assert "--actuator altitude_m" not in told


def test_what_was_confirmed_need_not_be_confirmed_again() -> None:
    assert advice_for(_diagnosis(Verdict.NAMED, replace(FOUND, evidence=Reach.TRANSFERRED))) == ()


def test_what_the_values_show_needs_no_second_recording() -> None:
    assert advice_for(_diagnosis(Verdict.UNKNOWN, SEEN)) == ()
    assert "--confirm" in " ".join(advice_for(_diagnosis(Verdict.PARTIAL, SEEN, FOUND)))


def test_no_actuator_is_tried_where_a_curve_of_a_channel_stands() -> None:
    given = replace(recording(), channels={"pump": np.ones(4000)})
    curve = replace(FOUND, effect=BY_NAME["channel_effect"](channel="pump"), how=How.CURVE)
    found = _diagnosis(Verdict.UNKNOWN, curve, problem=problem(given), where=(Share("pump", "body", 0.5),))
    told = " ".join(advice_for(found))
    assert "The curve of pump tells no mechanism" in told
    assert "--actuator" not in told


def test_without_attitude_attitude_is_asked_for() -> None:
    found = _diagnosis(Verdict.NONE, problem=problem(without_attitude(recording())))
    assert "log attitude" in advice_for(found)[0]
    assert "no interval" not in advice_for(found)[0]
    assert len(ADVICE) == 13


def test_where_parameters_have_no_interval_it_is_said_why() -> None:
    found = _diagnosis(Verdict.NAMED, FOUND, problem=problem(without_attitude(recording())))
    assert "strength was compared, so that parameters have no interval" in advice_for(found)[0]


def test_the_size_of_a_gap_is_a_share_of_its_excess_over_the_noise() -> None:
    """(g0^2 - g1^2) / (g0^2 - 1): from 3 to 2 sigma, five eighths."""
    size = GapSize.of(np.full((9, 1), 3.0), np.full((9, 1), 2.0), np.array([10.0]), POSED.policy)
    assert (size.before_nT, size.after_nT) == (30.0, 20.0)
    assert size.explained == pytest.approx(5 / 8)
    assert GapSize.of(np.ones((9, 1)), np.ones((9, 1)), np.ones(1), POSED.policy).explained is None


def test_events_are_told_with_their_moments() -> None:
    cls = next(effect for effect in EFFECTS if effect.with_role("moment"))
    on, off = (cls(**{str(cls.with_role("moment")): time_s}) for time_s in (33.7125, 90.7))
    assert f"{cls.name} at 33.71 s and 90.70 s: " in words_of(replace(FOUND, effect=on, also=(off,)))


@pytest.mark.parametrize(("period_s", "told"), [(298.13, True), (4000.0, False)])
def test_a_period_is_told_that_is_shorter_than_the_run(period_s: float, told: bool) -> None:
    """The run has 400 s."""
    cls = next(effect for effect in EFFECTS if effect.with_role("period"))
    swinging = replace(FOUND, effect=cls(**{str(cls.with_role("period")): period_s}))
    assert (f"{cls.name} every 298.1 s: " in sentence_for(_diagnosis(Verdict.NAMED, swinging))) == told


def test_of_two_changes_of_the_iron_it_is_said_when_each_acts() -> None:
    on = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0), active_s=(30.0, 90.0)), alternatives=("sensor_offset",))
    found = _diagnosis(Verdict.PARTIAL, on, _or(IRON, "sensor_offset"))
    told = sentence_for(found)
    assert "hard_iron (or sensor_offset) from 30 s to 90 s" in told
    assert "; hard_iron (or sensor_offset) in the whole run: offset_nT" in told
    assert "whole run" not in sentence_for(_diagnosis(Verdict.PARTIAL, FOUND, IRON))
    assert sum("may also be" in line for line in advice_for(found)) == 1


@pytest.mark.parametrize(("stood", "told"), [((0.0, 100.0), True), ((100.0, 400.0), True), ((0.0, 50.0), False)])
def test_iron_that_begins_where_the_vehicle_stops_standing_may_be_the_field_there(
    stood: tuple[float, float], told: bool
) -> None:
    """It acts from 100 s on; the run has 400 s."""
    on = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0), active_s=(100.0, 500.0)))
    time_s, field_nT = POSED.state.time_s, POSED.state.field_nT.copy()
    field_nT[(time_s >= stood[0]) & (time_s < stood[1])] = field_nT[0]
    posed = replace(POSED, state=replace(POSED.state, field_nT=field_nT))
    lines = advice_for(_diagnosis(Verdict.PARTIAL, on, problem=posed))
    assert any("turn it there too" in line for line in lines) is told
    always = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0)))
    assert "turn it there too" not in " ".join(advice_for(_diagnosis(Verdict.PARTIAL, always, problem=posed)))


def test_of_several_motors_the_sentence_says_whose_gain_it_tells() -> None:
    two, one = (DRIVEN(**{DRIVEN.linear[0]: (gain, 0.0, 0.0), "motor": motor}) for motor, gain in ((2, 5.0), (1, 3.0)))
    both = replace(FOUND, effect=two, also=(one,))
    assert words_of(both).startswith(f"{DRIVEN.name}: {DRIVEN.linear[0]} of current_2_A (5, 0, 0) nT/A")
    rods = {"current_1_A": "rod_x", "current_2_A": "rod_y"}
    assert words_of(both, "", rods).startswith(f"{DRIVEN.name} of rod_x, rod_y: {DRIVEN.linear[0]} of rod_y (5, 0, 0)")
    alone = replace(FOUND, effect=two)
    assert words_of(alone, "", rods).startswith(f"{DRIVEN.name} of rod_y: {DRIVEN.linear[0]} (5, 0, 0)")


def test_a_leading_name_at_the_ends_of_what_it_can_be_is_doubted() -> None:
    cls = next(effect for effect in EFFECTS if effect.name == "hysteresis")
    loop = Named(cls(gain=(0.01, -1.0, 0.0), threshold_nT=500.0), (), How.HELD_OUT, 50.0, 20.0)
    beside = replace(FOUND, strength=21.0)
    assert "hysteresis would have to be larger" in doubts_of(_case(loop, beside, clean=False), Verdict.PARTIAL)[0]
    small = replace(loop, strength=1.0)
    assert not doubts_of(_case(small, beside, clean=False), Verdict.PARTIAL)
    within = replace(loop, effect=cls(gain=(0.01, -0.9, 0.0), threshold_nT=500.0))
    assert not doubts_of(_case(within, beside, clean=False), Verdict.PARTIAL)
    above = replace(loop, effect=cls(gain=(0.01, 1.0, 0.0), threshold_nT=500.0))
    assert doubts_of(_case(above, beside, clean=False), Verdict.PARTIAL)
    iron = replace(IRON, effect=HardIron((-1e6, 0.0, 0.0)), strength=100.0)  # fitted in any case, and no name of a gap
    assert not doubts_of(_case(beside, iron, clean=False), Verdict.PARTIAL)
