"""When a recording's own answer stands before that of all together, what is left, and when names are doubted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.verdict_rules import judge
from diagnosis.evidence.gap_size import GapSize
from diagnosis.result import EvidenceKind, Explanation
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.workflow import check_apart
from diagnosis.verdict import Verdict
from scenarios.errors import InputError
from tests.diagnosis.several.told import GAP, motor, own, pooled
from tests.diagnosis.synthetic import problem, recording

WHITE, FITTED = EvidenceKind.SPECTRUM, EvidenceKind.HELD_OUT
POSED = problem(n=300)
LEFT, BASE = np.ones((300, 3)), np.full((300, 3), 2.0)


@pytest.mark.parametrize(
    ("verdict", "common", "each", "less"),
    [
        (Verdict.NONE, (), (Verdict.NONE, Verdict.NAMED), True),
        (Verdict.NONE, (), (Verdict.NONE, Verdict.NONE), False),
        (Verdict.NONE, (), (Verdict.UNKNOWN, Verdict.NONE), True),
        (Verdict.UNKNOWN, (), (Verdict.NONE, Verdict.NAMED), True),
        (Verdict.UNKNOWN, (), (Verdict.UNKNOWN, Verdict.NAMED), False),
        (Verdict.NAMED, (WHITE,), (Verdict.NONE, Verdict.NAMED), True),
        (Verdict.NAMED, (WHITE,), (Verdict.NONE, Verdict.NONE), False),
        (Verdict.NAMED, (WHITE, FITTED), (Verdict.NONE, Verdict.NAMED), False),
        (Verdict.PARTIAL, (WHITE,), (Verdict.NONE, Verdict.NAMED), False),
    ],
)
def test_a_recording_answers_alone_where_all_together_say_less(
    verdict: Verdict, common: tuple[EvidenceKind, ...], each: tuple[Verdict, ...], less: bool
) -> None:
    """A recording that is named has a fitted cause of its own here."""
    alone = [own(one, named=(motor(),) if one is Verdict.NAMED else ()) for one in each]
    effects = (CommonEffect(motor(kind=kind), (), ()) for kind in common)
    assert pooled(*effects, each=alone, verdict=verdict).says_less_than_each is less


def test_noise_and_steps_of_the_values_are_no_cause_of_its_own() -> None:
    for kind, less in ((WHITE, False), (EvidenceKind.DIRECT, False), (EvidenceKind.IRON, True)):
        each = [own(Verdict.NAMED, named=(motor(kind=kind),)), own()]
        assert pooled(each=each, verdict=Verdict.NAMED).says_less_than_each is less


def test_the_same_samples_twice_are_refused() -> None:
    one, other = recording(200, seed=1), recording(200, seed=2)
    check_apart(one, other, "a, b")
    with pytest.raises(InputError, match="a, b: both recordings have the same field samples"):
        check_apart(one, one, "a, b")


def judged(
    doubting: int, of: int, *, effects: bool = True, rises: bool = True
) -> tuple[Verdict, tuple[Explanation, ...]]:
    """A motor's field and a rounding in recordings, some of which have a larger gap with them."""
    sizes = [GapSize(20.0, 10.0, 60.0, 30.0, 0.9) if i < doubting else GAP for i in range(of)]
    named = tuple(motor(kind=kind) for kind in (FITTED, EvidenceKind.DIRECT)) if effects else ()
    rise: Any = SimpleNamespace(words="it rises", hides=False)
    rising = [rise if rises else None, *[None] * (of - 1)]
    tests: Any = [SimpleNamespace(clean=False, why=(f"why {i}",)) for i in range(of)]
    before_nT, after_nT = BASE * POSED.sigma_nT, LEFT * POSED.sigma_nT
    cases = [
        Explanation(POSED, named, True, size, (), before_nT, after_nT, *each)
        for size, *each in zip(sizes, tests, rising, strict=True)
    ]
    return judge(cases)


@pytest.mark.parametrize(("doubting", "of", "stands"), [(0, 3, True), (1, 3, True), (2, 4, False), (1, 2, False)])
def test_names_are_withdrawn_where_half_of_the_recordings_doubt_them(doubting: int, of: int, stands: bool) -> None:
    """What the values show stays; then nothing is explained."""
    verdict, cases = judged(doubting, of)
    kinds, last = [FITTED, EvidenceKind.DIRECT] if stands else [EvidenceKind.DIRECT], cases[-1]
    assert (verdict is not Verdict.UNKNOWN, [one.kind for one in last.named]) == (stands, kinds)
    assert last.gap == (GAP if stands else GAP.without_effects())
    np.testing.assert_allclose(last.after_nT, (LEFT if stands else BASE) * POSED.sigma_nT)
    np.testing.assert_allclose(last.before_nT, BASE * POSED.sigma_nT)
    told = [("why 0", "it rises"), ("why 1",)]
    doubt = ("the gap is larger with the named effects in the model",)
    assert [one.unexplained for one in cases[:2]] == told
    assert [one.doubts for one in cases] == [doubt if i < doubting else () for i in range(of)]


@pytest.mark.parametrize("effects", [True, False])
def test_slow_noise_beside_nothing_in_common_is_no_clean_residual(effects: bool) -> None:
    """Each recording is clean but for slow noise, whose tests are not."""
    verdict, _ = judged(0, 3, effects=effects, rises=False)
    assert verdict is (Verdict.COMPOSITE if effects else Verdict.UNKNOWN)
