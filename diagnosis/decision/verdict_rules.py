"""The verdict on a diagnosis, by ordered rules, and doubts about the named effects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from diagnosis.decision.monotone_courses import driving_channels, monotone_channels
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.localise import TIME, ChannelShare, channels, courses_on_within, find_followed_channel
from diagnosis.evidence.slow_noise import follows_time_only
from diagnosis.problem.sensors import as_currents
from diagnosis.problem.strength import turns_too_fast
from diagnosis.result import EvidenceKind, Explanation
from diagnosis.verdict import Verdict
from recordings.channels import current_name
from sim.effects import BY_NAME

Rule = Callable[[Explanation], bool]
Doubt = Callable[[Explanation], Iterator[str]]
"""(case) -> the reason why the named effects only resemble the cause, if it holds."""


def judge(cases: Sequence[Explanation]) -> tuple[Verdict, tuple[Explanation, ...]]:
    """The verdict on all recordings as one, and the doubts of each; names that half of them doubt are withdrawn.

    Without names slow noise does not count as clean, and what explains little is no name.
    """
    clean = all(case.clean if case.named else case.after.clean for case in cases)
    rise, gap = next((case.rise for case in cases if case.rise), None), GapSize.joint([case.gap for case in cases])
    verdict = verdict_of(replace(cases[0], clean=clean, gap=gap, rise=rise))
    judged = [replace(case, doubts=doubts_of(case, verdict)) for case in cases]
    if verdict is Verdict.UNKNOWN or 2 * sum(bool(case.doubts) for case in judged) >= len(judged):
        return Verdict.UNKNOWN, tuple(case.without_effects() for case in judged)
    return verdict, tuple(judged)


def verdict_of(case: Explanation) -> Verdict:
    """Return the verdict of the first matching rule."""
    return next(verdict for verdict, holds in RULES if holds(case))


def doubts_of(case: Explanation, verdict: Verdict) -> tuple[str, ...]:
    """Reasons why the named effects only resemble the cause; empty if none, or if nothing can be decided."""
    without_effects = (driver_unnamed,) if verdict.explained and case.named else ()
    decisive = _raised(DECISIVE_DOUBTS if case.of_kind(EvidenceKind.HELD_OUT) else without_effects, case)
    mixed = not case.clean if verdict is Verdict.PARTIAL else bool(case.of_kind(EvidenceKind.SPECTRUM))
    doubted = mixed and verdict in (Verdict.PARTIAL, Verdict.COMPOSITE, Verdict.CLASS)
    if decisive or not doubted or case.gap.explained is None:
        return decisive[:1]
    return _raised(NAME_DOUBTS, case)


def _raised(doubts: Sequence[Doubt], case: Explanation) -> tuple[str, ...]:
    return tuple(reason for doubt in doubts for reason in doubt(case))


def driver_unnamed(case: Explanation) -> Iterator[str]:
    """Doubt where only iron, noise or steps are named, and the gap follows a channel more than time.

    A weak driver passes for slow noise or for the iron that holds its mean.
    """
    for leading in driving_channels(case.problem, case.where)[:1]:
        yield f"the gap follows {leading}, and no named effect does"


def gap_is_larger(case: Explanation) -> Iterator[str]:
    """Doubt where the named effects do not fit data outside the fit."""
    if case.gap.after_sigma > case.problem.policy.larger * case.gap.before_sigma:
        yield "the gap is larger with the named effects in the model"


def field_turns_too_fast(case: Explanation) -> Iterator[str]:
    """Doubt where the sensor is in no vehicle."""
    if turns_too_fast(case.problem):
        yield "the field turns faster than a vehicle does"


def part_of_swept_tone(case: Explanation) -> Iterator[str]:
    """Doubt where the named effects are one frequency of a sweeping tone."""
    if case.rise is not None and case.rise.hides:
        yield f"the named effects explain next to nothing of {case.rise.words}"


def channel_in_residual(case: Explanation) -> Iterator[str]:
    """Doubt where the residual follows the channels leading the gap, and follows them more than time.

    Shares are of the gap: the residual of a slow disturbance follows time and every channel resembling time. Among many
    channels one follows the residual a little by chance: any but the first must exceed time's share as well. A monotone
    channel counts as time.
    """
    policy, explained = case.problem.policy, case.gap.explained
    if not case.where or explained is None:
        return
    left = {share.channel: (1 - explained) * share.share for share in case.left}
    time, first, slow = left.get(TIME, 0.0), case.where[0], monotone_channels(case.problem)

    def follows(share: ChannelShare) -> bool:
        own = policy.quarter * share.share
        return left.get(share.channel, 0.0) > (max(own, time) if share is first else own + time)

    leading = [share for share in case.where if share.share > policy.half * first.share]
    following = [share.channel for share in leading if share.channel not in slow and follows(share)]
    if following:
        yield f"the residual still follows {', '.join(following)}"


def motion_in_residual(case: Explanation) -> Iterator[str]:
    """Doubt where an effect acts during the motion leading the gap, and the residual follows the motion as well."""
    windows = [cause.effect.active_s for cause in case.named if cause.effect.active_s is not None]
    if not (windows and case.where and case.left) or case.left[0].channel != case.where[0].channel:
        return
    courses = [(name, x) for name, x in channels(case.problem) if name == case.where[0].channel]
    if any(courses_on_within(case.problem, window, courses) for window in windows):
        yield f"acts while {case.where[0].channel} is on, and the residual follows it too"


def iron_follows_a_channel(case: Explanation) -> Iterator[str]:
    """Doubt where iron following a channel, none of whose effects is named, explains much more of the gap."""
    unnamed = unnamed_channels(case) & {share.channel for share in case.where}
    following = find_followed_channel(Baseline.of(case.problem), unnamed) if unnamed else None
    left = 1 - (case.gap.explained or 0.0)
    if following is not None and 1 - following.share <= case.problem.policy.half * left:
        yield f"a scale or an offset that follows {following.channel} explains far more"


def unnamed_channels(case: Explanation) -> set[str]:
    """Recorded channels driving no named effect and none of its look-alikes; currents of all motors count as one."""
    causes = {channel for cause in case.named for channel in cause.effect.required_inputs}
    causes |= {need for cause in case.named for name in cause.alternatives for need in BY_NAME[name].needs}
    known = set(case.problem.state.channels) - causes
    motors = {current_name(motor) for motor in case.problem.state.motors}
    return known - motors - set(as_currents(case.problem.recording)) if causes & motors else known


DECISIVE_DOUBTS: tuple[Doubt, ...] = (gap_is_larger, field_turns_too_fast, part_of_swept_tone)
"""Doubts about all named effects, whatever the verdict."""
NAME_DOUBTS: tuple[Doubt, ...] = (channel_in_residual, motion_in_residual, iron_follows_a_channel)


def _explains_some(case: Explanation) -> bool:
    """Whether the named effects explain enough of the gap, or each is certain and only noise is left.

    Without a gap, effects based on held-out data explain nothing.
    """
    policy, explained, held_out = case.problem.policy, case.gap.explained, case.of_kind(EvidenceKind.HELD_OUT)
    if explained is None and not held_out:
        return True
    if explained is not None and (explained >= policy.fair_share or explained <= 0):
        return explained > 0
    sure = bool(held_out) and all((cause.nats or 0.0) > policy.sure_nats for cause in held_out)
    return sure and follows_time_only(case.problem, case.residual)


def _only_iron_with_rivals(case: Explanation) -> bool:
    """Whether only changes of the iron are named, and an effect other than iron is a look-alike."""
    rivals = {alternative for cause in case.named for alternative in cause.alternatives}
    only_iron = all(cause.kind is EvidenceKind.IRON for cause in case.named)
    return only_iron and not all(BY_NAME[name].traits.absorbed for name in rivals)


def _may_be_one_channel(case: Explanation) -> bool:
    """Whether one effect with rival channels is named, next to slow noise and constants of the iron alone.

    A curve of the rival channel may bend like the noise, and its zero may lie elsewhere: several causes are not shown.
    """
    rest = [cause for cause in case.named if not cause.rivals]
    constant = [cause.effect.traits.constant for cause in rest if cause.kind is EvidenceKind.IRON]
    noise = sum(cause.kind is EvidenceKind.SPECTRUM for cause in rest)
    return len(case.named) == len(rest) + 1 and sum(constant) + noise == len(rest)


RULES: tuple[tuple[Verdict, Rule], ...] = (
    (Verdict.NONE, lambda case: not case.named and case.clean and case.rise is None),
    (Verdict.UNKNOWN, lambda case: not case.named),
    (Verdict.PARTIAL, lambda case: not case.clean and _explains_some(case)),
    (Verdict.UNKNOWN, lambda case: not case.clean),
    (Verdict.PARTIAL, lambda case: case.rise is not None),
    (Verdict.NOT_OBSERVABLE, _only_iron_with_rivals),
    (Verdict.CLASS, _may_be_one_channel),
    (Verdict.COMPOSITE, lambda case: len(case.named) > 1),
    (Verdict.NAMED, lambda case: not case.named[0].look_alikes),
    (Verdict.GENERIC, lambda case: bool(case.of_kind(EvidenceKind.SPECTRUM))),
    (Verdict.CLASS, lambda case: True),
)
"""An effect is named only where the residual is clean."""
