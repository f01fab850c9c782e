"""From what was found to one verdict: rules in their order, then doubts of the names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from diagnosis.decision.monotone_courses import channels_of_time
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.channel_following import iron_follows
from diagnosis.evidence.localise import TIME, Share, channels, localise
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.evidence.slow_noise import goes_with_time_alone
from diagnosis.evidence.smooth_windows import on_in
from diagnosis.problem.actuators import as_currents
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import turns_too_fast
from diagnosis.result import GapSize, How, Named
from diagnosis.verdict import Verdict
from recordings.channels import current_name
from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.effects.base import PLAIN, Effect


@dataclass(frozen=True)
class VerdictInput:
    """What a verdict is read from: names, whether what is left is clean, and the gap.

    where: channels that the gap goes with; left (n, q): what the names leave, in units of the noise; rise: where its
    spectrum rises.
    """

    problem: LinearProblem
    named: tuple[Named, ...]
    clean: bool
    gap: GapSize
    where: tuple[Share, ...]
    left: Array
    rise: RisingSpectrum | None = None

    @property
    def noisy(self) -> bool:
        """Whether noise is among the names."""
        return any(one.how is How.SPECTRUM for one in self.named)

    @property
    def found(self) -> tuple[Named, ...]:
        """The names that rest on held-out data."""
        return tuple(one for one in self.named if one.how is How.HELD_OUT)


Rule = Callable[[VerdictInput], bool]
NameDoubt = Callable[[VerdictInput], str | None]


def verdict_of(case: VerdictInput) -> Verdict:
    """The verdict of the first rule that holds."""
    return next(verdict for verdict, holds in RULES if holds(case))


def doubts_of(case: VerdictInput, verdict: Verdict) -> tuple[str, ...]:
    """Why the names only resemble the cause; empty where nothing speaks against them, or nothing can be told."""
    sure = next(filter(None, (doubt(case) for doubt in SURE_DOUBTS)), None) if case.found else None
    if sure is not None:
        return (sure,)
    mixed = not case.clean if verdict is Verdict.PARTIAL else case.noisy
    if verdict not in (Verdict.PARTIAL, Verdict.COMPOSITE, Verdict.CLASS) or not mixed or case.gap.explained is None:
        return ()
    return tuple(reason for doubt in NAME_DOUBTS if (reason := doubt(case)) is not None)


def gap_is_larger(case: VerdictInput) -> str | None:
    """The names do not fit what they were not fitted to."""
    larger = case.gap.after_sigma > case.problem.policy.larger_gap * case.gap.before_sigma
    return "with the names in the model the gap is larger" if larger else None


def field_turns_too_fast(case: VerdictInput) -> str | None:
    """The sensor is in no vehicle."""
    return "the field turns faster than a vehicle does" if turns_too_fast(case.problem) else None


def part_of_what_rises(case: VerdictInput) -> str | None:
    """The names are the part of a tone that sweeps where it happens to stay."""
    if case.rise is None or not case.rise.hides:
        return None
    return f"where they act the names explain next to nothing: {case.rise.words} is left"


def channel_is_left(case: VerdictInput) -> str | None:
    """What is left still goes with the channels that the gap goes with, and with these more than with time.

    Shares are of the gap: what a slow disturbance of its own leaves goes with time, and with every channel that does.
    By chance with one of many a little more: any but the first must exceed time's share by all that speaks against. A
    channel that only rises is time by another name.
    """
    policy, explained = case.problem.policy, case.gap.explained
    if not case.where or explained is None:
        return None
    left = {one.channel: (1 - explained) * one.share for one in localise(case.problem, case.left)}
    time, (first, *others) = left.get(TIME, 0.0), case.where
    beside = [one for one in others if one.share > policy.leading_share * first.share]
    needed = {first.channel: max(policy.channel_left * first.share, time)}
    needed |= {one.channel: policy.channel_left * one.share + time for one in beside}
    other = needed.keys() - channels_of_time(case.problem)
    kept = [channel for channel, least in needed.items() if channel in other and left.get(channel, 0.0) > least]
    return f"what is left still goes with {', '.join(kept)}" if kept else None


def motion_is_left(case: VerdictInput) -> str | None:
    """A name acts while the motion that leads the gap is on, and what is left goes with that: a piece of its course."""
    left = localise(case.problem, case.left)
    if not (case.where and left) or left[0].channel != case.where[0].channel:
        return None
    leading = [(name, x) for name, x in channels(case.problem) if name == left[0].channel]
    windows = [window for one in case.named if (window := one.effect.active_s) is not None]
    acts = any(on_in(case.problem, window, leading) for window in windows)
    return f"acts while {left[0].channel} is on, and what is left goes with that too" if acts else None


def iron_follows_a_channel(case: VerdictInput) -> str | None:
    """Iron that follows a channel, which no name has for its cause, leaves much less of the gap than the names do."""
    explained = case.gap.explained or 0.0
    asked = unnamed_channels(case) & {one.channel for one in case.where}
    found = iron_follows(Baseline.of(case.problem), asked) if asked else None
    if found is None or 1 - found.share > case.problem.policy.curve_left * (1 - explained):
        return None
    return f"a scale or an offset that follows {found.channel} explains far more"


def at_its_bounds(case: VerdictInput) -> str | None:
    """A leading name has coefficients at the ends of what it can have: what is sought is no such effect.

    Those of a fuller form are none: what a core had before the run dies out, and may then be of any size.
    """
    most = max((one.strength for one in case.found), default=0.0)
    leading = [one for one in case.found if one.strength > case.problem.policy.leading_share * most]
    names = [one.name for one in leading if any(map(_at_an_end, one.effects))]
    return f"{', '.join(names)} would have to be larger than it can be" if names else None


def _at_an_end(effect: Effect) -> bool:
    free = (p for p in effect.parameters() if p.role == "linear" and p.form == PLAIN)
    values = ((p, np.asarray(getattr(effect, p.name))) for p in free)
    return any(bool(((x <= p.low) | (x >= p.high)).any()) for p, x in values)


def unnamed_channels(case: VerdictInput) -> set[str]:
    """Recorded channels that no name, nor what it may be instead, has for its cause; all motors' currents are one."""
    causes = {cause for one in case.named for cause in one.effect.required_inputs}
    causes |= {need for one in case.named for name in one.alternatives for need in BY_NAME[name].needs}
    known = set(case.problem.state.channels) - causes
    motors = {current_name(motor) for motor in case.problem.state.motors}
    return known - motors - set(as_currents(case.problem.recording)) if causes & motors else known


SURE_DOUBTS: tuple[NameDoubt, ...] = (gap_is_larger, field_turns_too_fast, part_of_what_rises)
"""Doubts that speak against every name, whatever the verdict."""
NAME_DOUBTS: tuple[NameDoubt, ...] = (at_its_bounds, channel_is_left, motion_is_left, iron_follows_a_channel)


def _nothing(case: VerdictInput) -> bool:
    return not case.named


def _explains_some(case: VerdictInput) -> bool:
    """Whether names explain enough of the gap, or a part of which each is sure, beside noise and no other cause.

    Where there is no gap to speak of, those that rest on it explain none.
    """
    policy, explained = case.problem.policy, case.gap.explained
    if explained is None and not case.found:
        return True
    if explained is not None and (explained >= policy.least_share or explained <= 0):
        return explained > 0
    sure = bool(case.found) and all((one.nats or 0.0) > policy.sure_nats for one in case.found)
    return sure and goes_with_time_alone(case.problem, case.left)


def _only_iron_with_rivals(case: VerdictInput) -> bool:
    """Changes of the iron alone, for one of which an effect could stand that is no iron."""
    rivals = (other for one in case.named for other in one.alternatives)
    return all(one.how is How.IRON for one in case.named) and any(not BY_NAME[name].traits.absorbed for name in rivals)


def _may_be_one_course(case: VerdictInput) -> bool:
    """Whether all beside one name that another channel drives as well is slow noise, or a constant of the iron.

    The curve of that channel may bend so, and its zero lie elsewhere: several causes are then not shown.
    """
    alike = [one for one in case.named if one.rivals]
    others = [one for one in case.named if not one.rivals]
    constant = [one for one in others if one.how is How.IRON and one.effect.traits.constant]
    noise = [one for one in others if one.how is How.SPECTRUM]
    return len(alike) == 1 and len(constant) + len(noise) == len(others)


RULES: tuple[tuple[Verdict, Rule], ...] = (
    (Verdict.NONE, lambda case: _nothing(case) and case.clean and case.rise is None),
    (Verdict.UNKNOWN, _nothing),
    (Verdict.PARTIAL, lambda case: not case.clean and _explains_some(case)),
    (Verdict.UNKNOWN, lambda case: not case.clean),
    (Verdict.PARTIAL, lambda case: case.rise is not None),
    (Verdict.NOT_OBSERVABLE, _only_iron_with_rivals),
    (Verdict.CLASS, _may_be_one_course),
    (Verdict.COMPOSITE, lambda case: len(case.named) > 1),
    (Verdict.NAMED, lambda case: not case.named[0].others),
    (Verdict.GENERIC, lambda case: case.noisy),
    (Verdict.CLASS, lambda case: True),
)
"""A name only where what is left is clean."""
