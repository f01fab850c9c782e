"""When a recording's own answer stands before that of all together, what is left, and when names are doubted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.result import EvidenceKind, Explanation, GapSize
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.workflow import PooledVerdict, check_apart
from diagnosis.verdict import Verdict
from scenarios.errors import InputError
from tests.diagnosis.several.told import GAP, motor, own
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
    pooled = PooledVerdict(verdict, tuple(CommonEffect(motor(kind=kind), (), ()) for kind in common), ())
    alone = [own(one, named=(motor(),) if one is Verdict.NAMED else ()) for one in each]
    assert pooled.says_less_than(alone) is less


def test_noise_and_steps_of_the_values_are_no_cause_of_its_own() -> None:
    pooled = PooledVerdict(Verdict.NAMED, (), ())
    for kind, less in ((WHITE, False), (EvidenceKind.DIRECT, False), (EvidenceKind.IRON, True)):
        assert pooled.says_less_than([own(Verdict.NAMED, named=(motor(kind=kind),)), own()]) is less


def test_the_same_samples_twice_are_refused() -> None:
    one, other = recording(200, seed=1), recording(200, seed=2)
    check_apart(one, other, "a, b")
    with pytest.raises(InputError, match="a, b: both recordings have the same field samples"):
        check_apart(one, one, "a, b")


def judged(doubting: int, of: int, *, effects: bool = True, rises: bool = True) -> PooledVerdict:
    """A motor's field and a rounding in recordings, some of which have a larger gap with them."""
    sizes = [GapSize(20.0, 10.0, 60.0, 30.0, 0.9) if i < doubting else GAP for i in range(of)]
    common = tuple(CommonEffect(motor(kind=kind), (), ()) for kind in (FITTED, EvidenceKind.DIRECT)) if effects else ()
    named = tuple(one.named for one in common)
    rise: Any = SimpleNamespace(words="it rises", hides=False)
    rising = [rise if rises else None, *[None] * (of - 1)]
    tests: Any = [SimpleNamespace(clean=False, why=(f"why {i}",)) for i in range(of)]
    before_nT, after_nT = BASE * POSED.sigma_nT, LEFT * POSED.sigma_nT
    cases = [
        Explanation(POSED, named, True, size, (), before_nT, after_nT, *each)
        for size, *each in zip(sizes, tests, rising, strict=True)
    ]
    return PooledVerdict.judge(common, cases)


@pytest.mark.parametrize(("doubting", "of", "stands"), [(0, 3, True), (1, 3, True), (2, 4, False), (1, 2, False)])
def test_names_are_withdrawn_where_half_of_the_recordings_doubt_them(doubting: int, of: int, stands: bool) -> None:
    """What the values show stays; then nothing is explained."""
    found = judged(doubting, of)
    kinds = [FITTED, EvidenceKind.DIRECT] if stands else [EvidenceKind.DIRECT]
    assert (found.verdict is not Verdict.UNKNOWN, [one.named.kind for one in found.common]) == (stands, kinds)
    last = found.gaps[-1]
    assert last.size == (GAP if stands else GAP.without_effects())
    np.testing.assert_allclose(last.after_nT, (LEFT if stands else BASE) * POSED.sigma_nT)
    np.testing.assert_allclose(last.before_nT, BASE * POSED.sigma_nT)
    told = [("why 0", "it rises"), ("why 1",)]
    doubt = ("the gap is larger with the named effects in the model",)
    assert [one.left for one in found.gaps[:2]] == [
        (*words, *(doubt if i < doubting else ())) for i, words in enumerate(told)
    ]


@pytest.mark.parametrize("effects", [True, False])
def test_slow_noise_beside_nothing_in_common_is_no_clean_residual(effects: bool) -> None:
    """Each recording is clean but for slow noise, whose tests are not."""
    verdict = judged(0, 3, effects=effects, rises=False).verdict
    assert verdict is (Verdict.COMPOSITE if effects else Verdict.UNKNOWN)
