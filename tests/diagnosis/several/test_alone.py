"""When a recording's own answer stands before that of all together, what is left, and when names are doubted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.verdict_rules import VerdictInput
from diagnosis.evidence.localise import ChannelShare
from diagnosis.policy import STANDARD
from diagnosis.result import EvidenceKind
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.verdict_rules import PooledVerdict
from diagnosis.several.workflow import _answers_better_alone, check_apart, mean_shares
from diagnosis.verdict import Verdict
from scenarios.errors import InputError
from tests.diagnosis.several.told import GAP, motor, own
from tests.diagnosis.synthetic import problem, recording

WHITE, FITTED = EvidenceKind.SPECTRUM, EvidenceKind.HELD_OUT
POSED = problem(n=300)


@pytest.mark.parametrize(
    ("verdict", "common", "each", "first"),
    [
        (Verdict.NONE, (), (Verdict.NONE, Verdict.NAMED), 1),
        (Verdict.NONE, (), (Verdict.NONE, Verdict.NONE), None),
        (Verdict.NONE, (), (Verdict.UNKNOWN, Verdict.NONE), 0),
        (Verdict.UNKNOWN, (), (Verdict.NONE, Verdict.NAMED), 1),
        (Verdict.UNKNOWN, (), (Verdict.UNKNOWN, Verdict.NAMED), None),
        (Verdict.NAMED, (WHITE,), (Verdict.NONE, Verdict.NAMED), 1),
        (Verdict.NAMED, (WHITE,), (Verdict.NONE, Verdict.NONE), None),
        (Verdict.NAMED, (WHITE, FITTED), (Verdict.NONE, Verdict.NAMED), None),
        (Verdict.PARTIAL, (WHITE,), (Verdict.NONE, Verdict.NAMED), None),
    ],
)
def test_a_recording_answers_alone_where_all_together_say_less(
    verdict: Verdict, common: tuple[EvidenceKind, ...], each: tuple[Verdict, ...], first: int | None
) -> None:
    """A recording that is named has a fitted cause of its own here."""
    pooled: Any = SimpleNamespace(
        verdict=verdict, common=tuple(SimpleNamespace(named=motor(kind=kind)) for kind in common)
    )
    alone = [own(one, named=(motor(),) if one is Verdict.NAMED else ()) for one in each]
    assert _answers_better_alone(pooled, alone) == first


def test_noise_and_steps_of_the_values_are_no_cause_of_its_own() -> None:
    pooled: Any = SimpleNamespace(verdict=Verdict.NAMED, common=())
    for kind, first in ((WHITE, None), (EvidenceKind.DIRECT, None), (EvidenceKind.IRON, 0)):
        assert _answers_better_alone(pooled, [own(Verdict.NAMED, named=(motor(kind=kind),)), own()]) == first


def test_the_same_samples_twice_are_refused() -> None:
    one, other = recording(200, seed=1), recording(200, seed=2)
    check_apart(one, other, "a, b")
    with pytest.raises(InputError, match="a, b: both recordings have the same field samples"):
        check_apart(one, one, "a, b")


def judged(doubts: tuple[tuple[str, ...], ...], verdict: Verdict = Verdict.NAMED) -> PooledVerdict:
    """A motor's field and a rounding in recordings that leave something, with doubts about them."""
    conclusions: Any = tuple(SimpleNamespace(after=SimpleNamespace(why=(f"why {k}",))) for k in range(len(doubts)))
    left, base = np.ones((4, 3)), np.full((4, 3), 2.0)
    cases = tuple(
        VerdictInput(POSED, (), False, GAP, (), left, None if k else SimpleNamespace(words="it rises"))  # type: ignore[arg-type]
        for k in range(len(doubts))
    )
    common = tuple(CommonEffect(motor(kind=kind), (), ()) for kind in (FITTED, EvidenceKind.DIRECT))
    return PooledVerdict(verdict, common, conclusions, cases, doubts, (base,) * len(doubts))


@pytest.mark.parametrize(
    ("count", "of", "doubted"), [(0, 3, False), (1, 3, False), (2, 3, True), (1, 2, True), (2, 4, True), (1, 4, False)]
)
def test_names_are_doubted_where_half_of_the_recordings_do(count: int, of: int, doubted: bool) -> None:
    doubts = tuple(("a doubt",) if k < count else () for k in range(of))
    assert judged(doubts).is_doubted is doubted
    assert judged(((),) * of, Verdict.UNKNOWN).is_doubted


def test_names_that_are_taken_back_leave_what_the_values_show() -> None:
    found = judged(((), ())).without_names()
    assert (found.verdict, [effect.named.kind for effect in found.common]) == (Verdict.UNKNOWN, [EvidenceKind.DIRECT])
    for case, before in zip(found.cases, found.before, strict=True):
        assert case.residual is before
        assert (case.gap.after_sigma, case.gap.explained) == (GAP.before_sigma, 0.0)


def test_what_is_left_is_told_by_recording() -> None:
    assert judged((("a doubt",), ())).unexplained(["first", "second"]) == (
        *("first: why 0", "first: it rises", "first: a doubt"),
        "second: why 1",
    )


def test_a_channel_s_share_is_its_mean_over_all_recordings_the_largest_first() -> None:
    """A recording in which it has no share counts as none; the list is cut."""
    several = [
        [ChannelShare("temperature", "body", 0.6), ChannelShare("current", "body", 0.3)],
        [ChannelShare("current", "body", 0.6)],
        [],
    ]
    found = mean_shares(several, STANDARD)
    assert [(one.channel, one.frame) for one in found] == [("current", "body"), ("temperature", "body")]
    assert [one.share for one in found] == pytest.approx([0.3, 0.2])
    many = [[ChannelShare(f"c{k}", "earth", 0.01 * k) for k in range(50)]]
    assert [one.channel for one in mean_shares(many, STANDARD)] == [f"c{49 - k}" for k in range(STANDARD.most_channels)]
