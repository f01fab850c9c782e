"""Every rule of the verdict and every doubt of a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision import verdict_rules
from diagnosis.decision.verdict_rules import (
    doubts_of,
    verdict_of,
)
from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.localise import ChannelShare
from diagnosis.result import Explanation, NamedEffect
from diagnosis.verdict import Verdict
from sim.effects.iron import SoftIron
from tests.diagnosis.decision.answers import (
    FAST,
    FOUND,
    GAP,
    IRON,
    NOISE,
    POSED,
    RISING,
    SEEN,
    TURN,
    case_of,
    either,
    leaving,
)
from tests.diagnosis.synthetic import problem, recording, without_attitude
from validation.signals.amplitude import rms


def channel_in_residual(case: Explanation) -> str | None:
    """The doubt that a channel is left, if any."""
    return next(verdict_rules.channel_in_residual(case), None)


def motion_in_residual(case: Explanation) -> str | None:
    """The doubt that a motion is left, if any."""
    return next(verdict_rules.motion_in_residual(case), None)


@pytest.mark.parametrize(
    ("case", "verdict"),
    [
        (case_of(), Verdict.NONE),
        (case_of(clean=False), Verdict.UNKNOWN),
        (case_of(FOUND), Verdict.NAMED),
        (case_of(either(FOUND, "bandwidth")), Verdict.CLASS),
        (case_of(FOUND, IRON), Verdict.COMPOSITE),
        (case_of(FOUND, clean=False), Verdict.PARTIAL),
        (case_of(FOUND, clean=False, explained=0.4), Verdict.PARTIAL),
        (case_of(FOUND, clean=False, explained=0.15), Verdict.UNKNOWN),
        (case_of(FOUND, clean=False, explained=None), Verdict.UNKNOWN),
        (case_of(SEEN, clean=False, explained=None), Verdict.PARTIAL),
        (case_of(rise=FAST), Verdict.UNKNOWN),
        (case_of(FOUND, explained=0.0, rise=FAST), Verdict.PARTIAL),
        (case_of(IRON, explained=None, rise=FAST), Verdict.PARTIAL),
        (case_of(IRON), Verdict.NAMED),
        (case_of(either(IRON, "soft_iron")), Verdict.CLASS),
        (case_of(either(IRON, "eddy_current")), Verdict.NOT_OBSERVABLE),
        (case_of(RISING, IRON), Verdict.CLASS),
        (case_of(NOISE, RISING), Verdict.CLASS),
        (case_of(RISING, TURN), Verdict.COMPOSITE),
        (case_of(RISING, FOUND), Verdict.COMPOSITE),
        (case_of(RISING, RISING), Verdict.COMPOSITE),
        (case_of(NOISE), Verdict.NAMED),
        (case_of(either(NOISE, "offset_jump")), Verdict.GENERIC),
    ],
)
def test_rules_in_their_order(case: Explanation, verdict: Verdict) -> None:
    assert verdict_of(case) is verdict


def _still_driven(share: float) -> Explanation:
    """A case whose rest goes with the current by some share of its power."""
    current = POSED.state.current_A[:, 0] - POSED.state.current_A[:, 0].mean()
    noise = np.random.default_rng(0).normal(size=POSED.target.shape)
    left = noise * 1e-3 + np.sqrt(share) * (current / current.std())[:, None]
    where = (ChannelShare("current_1_A", "body", 0.9),)
    return leaving(case_of(FOUND, clean=False, explained=0.7, where=where), left)


@pytest.mark.parametrize(("nats", "explained", "verdict"), [
    (49.0, 0.1, Verdict.UNKNOWN), (51.0, 0.1, Verdict.PARTIAL), (51.0, None, Verdict.PARTIAL),
    (51.0, -0.01, Verdict.UNKNOWN),
])  # fmt: skip
def test_beside_noise_a_sure_name_stands_however_little_it_explains(
    nats: float, explained: float | None, verdict: Verdict
) -> None:
    """But not beside what goes with a channel, of which it may be a piece; nor does one that is sure lend its name.

    Nor where the gap is larger with it than without.
    """
    sure = replace(FOUND, nats=nats)
    assert verdict_of(case_of(sure, clean=False, explained=explained)) is verdict
    driven = replace(_still_driven(1.0), named=(sure,), gap=replace(GAP, explained=explained))
    assert verdict_of(driven) is Verdict.UNKNOWN
    other = replace(FOUND, nats=30.0)
    assert verdict_of(case_of(sure, other, clean=False, explained=explained)) is Verdict.UNKNOWN


@pytest.mark.parametrize(("name", "time", "doubted"), [
    (IRON, None, True), (NOISE, None, True), (IRON, 0.75, True), (IRON, 0.85, False), (FOUND, None, False),
])  # fmt: skip
def test_iron_or_noise_beside_a_gap_that_follows_a_channel_is_no_answer(
    name: NamedEffect, time: float | None, doubted: bool
) -> None:
    """A pump's mean is iron, and its switching resembles slow noise; time and what only rises is no driver."""
    clock = () if time is None else (ChannelShare("time_s", "body", time),)
    where = (ChannelShare("current_1_A", "body", 0.9), *clock)
    told = doubts_of(case_of(name, where=where), verdict_of(case_of(name, where=where)))
    assert told == (("the gap follows current_1_A, and no named effect does",) if doubted else ())


def test_a_name_after_which_the_channel_is_still_there_only_resembles_the_cause() -> None:
    assert channel_in_residual(_still_driven(1.0)) == "the residual still follows current_1_A"
    assert doubts_of(_still_driven(1.0), Verdict.PARTIAL)
    assert channel_in_residual(leaving(_still_driven(1.0), np.random.default_rng(1).normal(size=(4000, 3)))) is None
    # a quarter of its share of the gap, 0.9, is too much: three tenths of the gap are, two tenths are not
    assert channel_in_residual(replace(_still_driven(1.0), gap=replace(GAP, explained=0.8))) is None
    assert channel_in_residual(replace(_still_driven(1.0), where=())) is None


def test_any_channel_but_the_first_must_be_left_well_beyond_time() -> None:
    kept = _still_driven(1.0)
    slow = np.sin(0.02 * POSED.state.time_s)[:, None] * np.ones(3)
    near = leaving(kept, kept.residual + 1.7 * slow, gap=replace(GAP, explained=0.0))
    first, second = ChannelShare("rate_x", "body", 0.65), ChannelShare("current_1_A", "body", 0.65)
    assert channel_in_residual(replace(near, where=(second, first))) == "the residual still follows current_1_A"
    assert channel_in_residual(replace(near, where=(first, second))) is None
    assert channel_in_residual(replace(kept, where=(first, second))) == "the residual still follows current_1_A"
    little = ChannelShare(
        "current_1_A", "body", 0.3
    )  # of the gap goes with it, of what is left much more: it did not lead
    assert channel_in_residual(replace(kept, where=(first, little))) is None


def test_what_acts_while_a_motion_is_on_and_leaves_more_of_it_is_a_piece_of_its_course() -> None:
    """A window's constant is a piece of what goes with a rate: not where another leads, or it is on beside."""
    n = len(POSED.target)
    on = (np.arange(n) > 0.3 * n) & (np.arange(n) < 0.7 * n)
    rate = on * (1.0 + 0.2 * np.sin(np.arange(n) / 90.0))
    state = replace(POSED.state, channels={**POSED.state.channels, "rate": rate})
    time_s = POSED.state.time_s
    acts = replace(FOUND, effect=SoftIron(active_s=(time_s[on][0], time_s[on][-1])))
    left = (on * np.sin(np.arange(n) / 90.0))[:, None] * np.ones(3)
    leads = ChannelShare("rate", "body", 0.7)
    case = leaving(case_of(acts, clean=False, problem=replace(POSED, state=state), where=(leads,)), left)
    assert motion_in_residual(case) == "acts while rate is on, and the residual follows it too"
    assert motion_in_residual(case) in doubts_of(case, Verdict.PARTIAL)
    assert motion_in_residual(replace(case, where=(ChannelShare("pitch", "body", 0.8), leads))) is None
    assert motion_in_residual(leaving(case, 0 * left)) is None
    assert motion_in_residual(replace(case, named=(FOUND,))) is None
    shorter = replace(acts, effect=SoftIron(active_s=(time_s[on][0], time_s[n // 2])))
    assert motion_in_residual(replace(case, named=(shorter,))) is None


def test_what_goes_with_time_as_well_speaks_against_no_name() -> None:
    slow = np.sin(0.02 * POSED.state.time_s)[:, None] * np.ones(3)
    assert (
        channel_in_residual(leaving(case_of(FOUND, explained=0.7, where=(ChannelShare("time_s", "body", 0.9),)), slow))
        is None
    )
    current = _still_driven(1.0)
    assert channel_in_residual(leaving(current, current.residual + 9 * slow)) is None


def test_a_channel_that_only_rises_speaks_against_no_name() -> None:
    """A supply that sags, and with the load a little more: a slow rest goes with it by chance more than with time."""
    part = POSED.state.time_s / POSED.state.time_s[-1]
    sags = 12 - part - 0.02 * np.sin(90 * part)
    left = np.sin(20 * sags)[:, None] * np.ones(3)
    where = (ChannelShare("supply_V", "body", 0.9),)
    case = leaving(case_of(FOUND, clean=False, explained=0.5, where=where), left)
    assert (
        channel_in_residual(replace(case, problem=problem(replace(recording(), channels={"supply_V": sags})))) is None
    )
    periodic = np.sin(90 * part)
    driven = replace(recording(), channels={"supply_V": periodic})
    assert channel_in_residual(leaving(case, periodic[:, None] * np.ones(3), problem=problem(driven)))


def test_verdicts_that_leave_nothing_are_not_doubted() -> None:
    assert doubts_of(_still_driven(1.0), Verdict.NAMED) == ()
    assert doubts_of(replace(_still_driven(1.0), gap=replace(GAP, explained=None)), Verdict.PARTIAL) == ()
    noisy = replace(_still_driven(1.0), clean=True, named=(FOUND, NOISE))
    assert doubts_of(noisy, Verdict.COMPOSITE)
    assert all(doubts_of(noisy, verdict) == () for verdict in (Verdict.PARTIAL, Verdict.GENERIC, Verdict.NAMED))


def test_in_a_field_that_turns_too_fast_no_name_stands() -> None:
    """Sixty times the turns of a vehicle, without attitude and gyro: a wheel's magnets beside a sensor at rest."""
    slow = without_attitude(recording(1500))
    posed = [problem(slow), problem(replace(slow, time_s=slow.time_s / 60))]
    cases = [leaving(case_of(FOUND, problem=one), np.zeros_like(one.target)) for one in posed]
    doubts = [doubts_of(case, Verdict.NAMED) for case in cases]
    assert doubts == [(), ("the field turns faster than a vehicle does",)]


def test_only_names_that_act_where_something_fast_is_left_are_doubted() -> None:
    """However much of the gap that is: a drift beside a rotor's tone stands, a tone that is a part of it does not."""
    fast = case_of(FOUND, explained=0.02, rise=FAST)
    assert doubts_of(fast, Verdict.PARTIAL) == ()
    assert doubts_of(replace(_still_driven(1.0), clean=True, rise=FAST), Verdict.PARTIAL) == ()
    hidden = replace(FAST, hides=True)
    assert "structure between 2 and 4 Hz" in doubts_of(replace(fast, rise=hidden), Verdict.PARTIAL)[0]
    assert doubts_of(case_of(IRON, rise=hidden), Verdict.PARTIAL) == ()


def test_names_that_make_the_gap_larger_are_doubted() -> None:
    larger = replace(GAP, after_sigma=1.2 * GAP.before_sigma)
    assert doubts_of(replace(case_of(FOUND), gap=larger), Verdict.NAMED)
    assert doubts_of(replace(case_of(SEEN), gap=larger), Verdict.NAMED) == ()
    hardly = replace(GAP, after_sigma=1.05 * GAP.before_sigma)
    assert doubts_of(replace(case_of(FOUND), gap=hardly), Verdict.NAMED) == ()


def test_the_size_of_a_gap_is_a_share_of_its_excess_over_the_noise() -> None:
    """(g0^2 - g1^2) / (g0^2 - 1): from 3 to 2 sigma, five eighths."""
    ones, whole = np.ones_like(POSED.target), np.ones(len(POSED.target), bool)
    size = GapSize.of(POSED, 3 * ones, 2 * ones, whole)
    assert (size.before_nT, size.after_nT) == pytest.approx((3 * rms(POSED.sigma_nT), 2 * rms(POSED.sigma_nT)))
    assert size.explained == pytest.approx(5 / 8)
    assert GapSize.of(POSED, ones, ones, whole).explained is None
