"""What a lot believes and what it refuses: each rule with all others out of its way."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.result import GapSize, How, Transfer
from diagnosis.several import look_alikes as alike
from diagnosis.several import selection
from diagnosis.several.look_alikes import look_alikes
from diagnosis.several.pooled_test import PooledCandidate, columns_in
from diagnosis.several.selection import _along_the_field, _best, _finding, _is_form, _named, _stands
from diagnosis.several.transfer import There
from diagnosis.several.verdict_rules import PooledVerdict, _explains_little, joined
from diagnosis.verdict import Verdict
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.earth import FieldGradient, RegionalField
from tests.diagnosis.synthetic import problem

KIN = [effect for effect in EFFECTS if effect.traits.family][:2]
GAP = GapSize(20.0, 10.0, 4.0, 2.0, 0.9)
OPEN = GapSize(2.0, 1.0, 2.0, 1.0, None)


def _joint(effect: type[Effect] = RegionalField, gain: float = 100.0, asked: tuple[object, ...] = ("here",)) -> Any:
    made = SimpleNamespace(name=effect.name, gain=gain, candidate=Candidate(effect), asked=asked, columns=[effect.name])
    return SimpleNamespace(**vars(made), chance=5.0, policy=STANDARD, width=3, off_size=0.0, there=[])


@pytest.mark.parametrize(
    ("reach", "nats", "coloured", "adds", "along", "stands"),
    [
        (Transfer.TRANSFERRED, 9.0, False, False, False, True),
        (None, 9.0, False, True, True, False),
        (Transfer.TRANSFERRED, 7.0, False, True, True, False),
        (Transfer.TRANSFERRED, 9.0, True, True, True, True),
        (Transfer.TRANSFERRED, 9.0, True, False, True, False),
        (Transfer.TRANSFERRED, 9.0, True, True, False, False),
    ],
)
def test_an_effect_stands_beyond_chance_and_beside_a_colour_by_enough_of_the_gap(
    reach: Transfer | None,
    nats: float,
    coloured: bool,
    adds: bool,
    along: bool,
    stands: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in {"_most_by_chance": 8.0, "_adds": adds, "_along_the_field": along}.items():
        monkeypatch.setattr(selection, name, lambda *_, value=value: value)
    found: Any = SimpleNamespace(reach=reach, nats=nats, joint=None)
    assert _stands(found, [], [], coloured=coloured) is stands


@pytest.mark.parametrize(("shown", "holds"), [((True, False), True), ((True, False, False), False)])
def test_a_source_shows_along_the_field_in_half_of_the_recordings(
    shown: tuple[bool, ...], holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    each = iter(shown)
    monkeypatch.setattr(selection, "gains_along_the_field", lambda *_: next(each))
    found: Any = SimpleNamespace(there=[There.PRESENT] * len(shown), joint=_joint(FieldGradient))
    members: Any = [SimpleNamespace(ground=None, problem=SimpleNamespace(mode="vector"))] * len(shown)
    assert _along_the_field(found, members, members) is holds


@pytest.mark.parametrize("coloured", [True, False])
def test_a_finding_is_asked_beside_what_each_alone_has(coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "beside_own", lambda one, own: (one, own))
    monkeypatch.setattr(selection, "replace", lambda joint, asked: asked)
    monkeypatch.setattr(selection, "finding", lambda *given: given)
    member: Any = SimpleNamespace(problem=SimpleNamespace(policy=STANDARD), instead_of=lambda one: "own", named=[])
    asked, needed, _, named = _finding(_joint(), [member], coloured=coloured)  # type: ignore[misc]
    assert asked == (("here", "own"),)
    assert needed == (STANDARD.coloured_nats if coloured else STANDARD.accepted_together(len(EFFECTS)))
    assert named == []


@pytest.mark.parametrize(
    ("stands", "against", "useless", "another", "name"),
    [
        ({"regional_field", "motor_current"}, set(), False, False, "regional_field"),
        ({"motor_current"}, set(), False, False, "motor_current"),
        ({"motor_current"}, set(), True, False, None),
        ({"motor_current"}, set(), True, True, "motor_current"),
        ({"regional_field", "motor_current"}, {"regional_field"}, False, False, "motor_current"),
    ],
)
def test_the_likeliest_that_stands_is_chosen_but_not_what_a_better_one_takes_up(
    stands: set[str],
    against: set[str],
    useless: bool,
    another: bool,
    name: str | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where one recording has another cause, the next may be what all have."""

    def found(joint: Any, members: object, coloured: bool) -> Any:
        return SimpleNamespace(joint=_joint(asked=("other",)) if another else joint, of=joint.name)

    script: dict[str, Any] = {
        "_tried": lambda *_: [_joint(MotorCurrent, 50.0), _joint(RegionalField, 100.0)],
        "_clean": lambda *_: True,
        "_finding": found,
        "_stands": lambda found, *_, coloured: found.of in stands,
        "_named": lambda joint, *_, coloured: joint,
        "_is_refused": lambda one, members: one.name in against,
        "is_useless_beside": lambda columns, better: useless,
    }
    for key, value in script.items():
        monkeypatch.setattr(selection, key, value)
    chosen = _best([], {}, [])
    assert (chosen and chosen.name) == name


def test_what_is_of_the_kin_of_what_is_in_is_its_form() -> None:
    one, other, third = (SimpleNamespace(name=e.name, strength=9.0, finding=SimpleNamespace(joint=_joint(e)),
                         alone=lambda first: SimpleNamespace(strength=9.0)) for e in (*KIN, MotorCurrent))  # fmt: skip
    assert _is_form(other, [one], [], STANDARD)  # type: ignore[arg-type,list-item]
    assert not _is_form(third, [one], [], STANDARD)  # type: ignore[arg-type,list-item]


def test_a_name_is_the_simplest_with_all_that_look_like_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the simplest is not borne out by itself, the best is."""
    best, simple, near = _joint(RegionalField), _joint(MotorCurrent), _joint(FieldGradient)
    monkeypatch.setattr(selection, "look_alikes", lambda *_, coloured: ([best, simple], [near]))
    monkeypatch.setattr(selection, "simplest", lambda *_: simple)
    monkeypatch.setattr(selection, "explain_as_much", lambda *_: ["scale"])
    found: Any = SimpleNamespace(joint=best, reach=Transfer.TRANSFERRED)
    member: Any = SimpleNamespace(problem=SimpleNamespace(policy=STANDARD))
    for reach, name, other in ((Transfer.SOME, simple.name, best.name), (None, best.name, simple.name)):
        monkeypatch.setattr(
            selection, "_finding", lambda one, *_, coloured, r=reach: SimpleNamespace(joint=one, reach=r)
        )
        told = _named(best, found, [], {}, [member], coloured=True)
        assert (told.name, told.alternatives) == (name, (other, near.name, "scale"))


@pytest.mark.parametrize(
    ("best", "other", "gain", "coloured", "useless", "close", "near"),
    [
        (RegionalField, MotorCurrent, 996.0, False, True, True, False),
        (RegionalField, MotorCurrent, 994.0, False, True, False, False),
        (RegionalField, MotorCurrent, 996.0, False, False, False, False),
        (RegionalField, MotorCurrent, 890.0, True, True, False, True),
        (RegionalField, MotorCurrent, 870.0, True, True, False, False),
        (*KIN, 975.0, False, True, True, False),
        (*KIN, 960.0, False, True, False, False),
        (*KIN, 560.0, True, True, True, False),
    ],
)
def test_look_alikes_of_a_lot_are_of_no_use_beside_it(
    best: type[Effect],
    other: type[Effect],
    gain: float,
    coloured: bool,
    useless: bool,
    close: bool,
    near: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And gain as much by chance, or but for an error of form: more of kin, and beside a colour."""
    monkeypatch.setattr(alike, "is_useless_beside", lambda *_: useless)
    first, second = _joint(best, 1000.0), _joint(other, gain)
    closest, others = look_alikes(first, [first, second], STANDARD, coloured=coloured)
    assert [one.name for one in closest] == [best.name, *([other.name] if close else [])]
    assert bool(others) is near


@pytest.mark.parametrize(
    ("settings", "there"),
    [({}, True), ({"motor": 1}, True), ({"motor": 9}, False)],
)
def test_a_setting_is_asked_where_its_motor_is(settings: dict[str, object], there: bool) -> None:
    found = columns_in(Candidate(MotorCurrent, tuple(settings.items())), problem(n=300))
    assert (found is not None) is there


def test_a_channel_that_a_recording_lacks_or_that_is_off_is_not_asked() -> None:
    posed = problem(n=300)
    channel = next(effect for effect in EFFECTS if effect.with_role("channel"))
    assert columns_in(Candidate(channel, ((channel.with_role("channel"), "no such"),)), posed) is None
    off = {name: 0.0 * values for name, values in posed.state.channels.items()}
    assert columns_in(Candidate(MotorCurrent), replace(posed, state=replace(posed.state, channels=off))) is None


@pytest.mark.parametrize(("common", "without", "held", "gain"), [(9.0, 2.0, 3.0, 6.0), (9.0, 7.0, 3.0, 5.0)])
def test_a_candidate_of_a_lot_gains_by_common_or_by_own_coefficients_less_its_price(
    common: float, without: float, held: float, gain: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("diagnosis.several.pooled_test.left_out_gains", lambda estimates: np.array([common]))
    one = SimpleNamespace(estimate=None, without=without / 2, held=held)
    assert PooledCandidate.gain.fget(SimpleNamespace(there=[one, one], price=1.0)) == gain  # type: ignore[attr-defined]


def test_nats_are_over_the_inflation_of_their_error() -> None:
    wide = SimpleNamespace(inflation=lambda c: 4.0, c=None)
    joint: Any = SimpleNamespace(asked=[SimpleNamespace(nats_of=lambda c: 20.0, held=40.0)], estimates=[wide])
    assert (PooledCandidate.nats(joint, 0, np.zeros(1)), PooledCandidate.own(joint, 0)) == (5.0, 10.0)


@pytest.mark.parametrize(
    ("verdict", "doubts", "doubted"),
    [
        (Verdict.NAMED, ((), (), ()), False),
        (Verdict.NAMED, (("one",), (), ()), False),
        (Verdict.NAMED, (("one",), ("two",), ()), True),
        (Verdict.NAMED, (("one",), ()), True),
        (Verdict.UNKNOWN, ((), (), ()), True),
    ],
)
def test_half_of_the_recordings_speak_against_the_names_of_a_lot(
    verdict: Verdict, doubts: tuple[tuple[str, ...], ...], doubted: bool
) -> None:
    assert PooledVerdict.doubted.fget(SimpleNamespace(verdict=verdict, doubts=doubts)) is doubted  # type: ignore[attr-defined]


def test_names_that_are_taken_back_leave_what_the_values_show() -> None:
    several: Any = tuple(SimpleNamespace(named=SimpleNamespace(how=how)) for how in (How.HELD_OUT, How.DIRECT))
    nothing: Any = ()
    found = PooledVerdict(Verdict.NAMED, several, (), (), (), GAP, (GAP,), (np.zeros(1),), nothing).undone()
    assert (found.verdict, found.common, found.after) == (Verdict.UNKNOWN, several[1:], found.before)
    assert (found.gap.after_sigma, found.gap.explained) == (GAP.before_sigma, 0.0)


@pytest.mark.parametrize(
    ("clean", "explained", "found", "little"),
    [(False, 0.1, True, True), (True, 0.1, True, False), (False, 0.3, True, False), (False, 0.1, False, False)],
)
def test_names_that_leave_something_explain_enough_in_each(
    clean: bool, explained: float, found: bool, little: bool
) -> None:
    problem: Any = SimpleNamespace(policy=STANDARD)
    case: Any = SimpleNamespace(clean=clean, gap=replace(GAP, explained=explained), found=found, problem=problem)
    assert bool(_explains_little(case)) is little


def test_a_share_is_of_the_recordings_with_a_gap() -> None:
    whole = joined([GAP, replace(OPEN, after_sigma=3.0)])
    assert whole.explained == pytest.approx((10.0**2 - 2.0**2) / (10.0**2 - 1))
    assert joined([OPEN]).explained is None
