"""What a lot believes and what it refuses: each rule with all others out of its way."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.result import EvidenceKind, GapSize, Transfer
from diagnosis.several import look_alikes as alike
from diagnosis.several import selection
from diagnosis.several.coefficients import CoefficientEstimate
from diagnosis.several.look_alikes import look_alikes
from diagnosis.several.pooled_test import PooledCandidate, columns_in
from diagnosis.several.selection import (
    _along_the_field,
    _best_candidate,
    _common_alternatives,
    _explains_gap,
    _finding,
    _is_form_of_accepted,
    _is_supported,
    _largest_surrogate_gain,
    _settings,
    _with_alternatives,
)
from diagnosis.several.transfer import Presence
from diagnosis.several.verdict_rules import PooledVerdict, _predicted_coefficients, _small_share_doubt, joint_gap
from diagnosis.verdict import Verdict
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.earth import FieldGradient, RegionalField
from tests.diagnosis.synthetic import problem

KIN = [effect for effect in EFFECTS if effect.traits.family][:2]
GAP = GapSize(20.0, 10.0, 4.0, 2.0, 0.9)
OPEN = GapSize(2.0, 1.0, 2.0, 1.0, None)


def _pooled(
    effect: type[Effect] = RegionalField, gain: float = 100.0, in_recording: tuple[object, ...] = ("here",)
) -> Any:
    made = SimpleNamespace(
        name=effect.name, gain=gain, candidate=Candidate(effect), in_recordings=in_recording, columns=[effect.name]
    )
    return SimpleNamespace(**vars(made), indistinct_nats=5.0, policy=STANDARD, width=3, scale_error=0.0, tested=[])


@pytest.mark.parametrize(
    ("transfer", "nats", "coloured", "adds", "along", "stands"),
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
    transfer: Transfer | None,
    nats: float,
    coloured: bool,
    adds: bool,
    along: bool,
    stands: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in {"_largest_surrogate_gain": 8.0, "_explains_gap": adds, "_along_the_field": along}.items():
        monkeypatch.setattr(selection, name, lambda *_, value=value: value)
    found: Any = SimpleNamespace(transfer=transfer, nats=nats, pooled=None)
    assert _is_supported(found, [], [], coloured=coloured) is stands


@pytest.mark.parametrize(("shown", "holds"), [((True, False), True), ((True, False, False), False)])
def test_a_source_shows_along_the_field_in_half_of_the_recordings(
    shown: tuple[bool, ...], holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    each = iter(shown)
    monkeypatch.setattr(selection, "explains_along_field", lambda *_: next(each))
    found: Any = SimpleNamespace(presence=[Presence.PRESENT] * len(shown), pooled=_pooled(FieldGradient))
    recordings: Any = [SimpleNamespace(baseline=None, problem=SimpleNamespace(mode="vector"))] * len(shown)
    assert _along_the_field(found, recordings, recordings) is holds


@pytest.mark.parametrize("coloured", [True, False])
def test_a_finding_is_asked_beside_what_each_alone_has(coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "with_own_effects", lambda one, own: (one, own))
    monkeypatch.setattr(selection, "replace", lambda pooled, in_recordings: in_recordings)
    monkeypatch.setattr(selection, "assess_transfer", lambda *given: given)
    recording: Any = SimpleNamespace(
        problem=SimpleNamespace(policy=STANDARD), competing_columns=lambda one: "own", own_effects=[]
    )
    in_recording, needed, _, named = _finding(_pooled(), [recording], coloured=coloured)  # type: ignore[misc]
    assert in_recording == (("here", "own"),)
    assert needed == (STANDARD.coloured_nats if coloured else STANDARD.accepted_pooled(len(EFFECTS)))
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

    def found(pooled: Any, recordings: object, coloured: bool) -> Any:
        return SimpleNamespace(pooled=_pooled(in_recording=("other",)) if another else pooled, of=pooled.name)

    script: dict[str, Any] = {
        "_screened": lambda *_: [_pooled(MotorCurrent, 50.0), _pooled(RegionalField, 100.0)],
        "_residuals_are_clean": lambda *_: True,
        "_finding": found,
        "_is_supported": lambda found, *_, coloured: found.of in stands,
        "_with_alternatives": lambda pooled, *_, coloured: pooled,
        "_is_contradicted": lambda one, recordings: one.name in against,
        "is_explained_by": lambda columns, better: useless,
    }
    for key, value in script.items():
        monkeypatch.setattr(selection, key, value)
    chosen = _best_candidate([], {}, [])
    assert (chosen and chosen.name) == name


def test_what_is_of_the_kin_of_what_is_in_is_its_form() -> None:
    alone = SimpleNamespace(strength=9.0)
    one, other, third = (
        SimpleNamespace(
            name=e.name,
            strength=9.0,
            finding=SimpleNamespace(pooled=_pooled(e)),
            without_others=lambda first: alone,
        )
        for e in (*KIN, MotorCurrent)
    )
    assert _is_form_of_accepted(other, [one], [], STANDARD)  # type: ignore[arg-type,list-item]
    assert not _is_form_of_accepted(third, [one], [], STANDARD)  # type: ignore[arg-type,list-item]


def test_a_name_is_the_simplest_with_all_that_look_like_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the simplest is not borne out by itself, the best is."""
    best, simple, near = _pooled(RegionalField), _pooled(MotorCurrent), _pooled(FieldGradient)
    monkeypatch.setattr(selection, "look_alikes", lambda *_, coloured: ([best, simple], [near]))
    monkeypatch.setattr(selection, "select_simplest", lambda *_: simple)
    monkeypatch.setattr(selection, "fit_equally_well", lambda *_: ["scale"])
    found: Any = SimpleNamespace(pooled=best, transfer=Transfer.TRANSFERRED)
    recording: Any = SimpleNamespace(problem=SimpleNamespace(policy=STANDARD))
    for transfer, name, other in ((Transfer.SOME, simple.name, best.name), (None, best.name, simple.name)):
        monkeypatch.setattr(
            selection, "_finding", lambda one, *_, coloured, r=transfer: SimpleNamespace(pooled=one, transfer=r)
        )
        told = _with_alternatives(best, found, [], {}, [recording], coloured=True)
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
    monkeypatch.setattr(alike, "is_explained_by", lambda *_: useless)
    first, second = _pooled(best, 1000.0), _pooled(other, gain)
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
    monkeypatch.setattr("diagnosis.several.pooled_test.cross_predicted_gains", lambda estimates: np.array([common]))
    one = SimpleNamespace(estimate=None, null_gain=without / 2, held_out_gain=held)
    assert PooledCandidate.gain.fget(SimpleNamespace(tested=[one, one], price=1.0)) == gain  # type: ignore[attr-defined]


def test_nats_are_over_the_inflation_of_their_error() -> None:
    wide = SimpleNamespace(inflation=lambda c: 4.0, c=None)
    pooled: Any = SimpleNamespace(
        in_recordings=[SimpleNamespace(nats_at=lambda c: 20.0, held_out_gain=40.0)], estimates=[wide]
    )
    assert (PooledCandidate.nats(pooled, 0, np.zeros(1)), PooledCandidate.own_nats(pooled, 0)) == (5.0, 10.0)


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
    assert PooledVerdict.is_doubted.fget(SimpleNamespace(verdict=verdict, doubts=doubts)) is doubted  # type: ignore[attr-defined]


def test_names_that_are_taken_back_leave_what_the_values_show() -> None:
    several: Any = tuple(
        SimpleNamespace(named=SimpleNamespace(kind=how)) for how in (EvidenceKind.HELD_OUT, EvidenceKind.DIRECT)
    )
    nothing: Any = ()
    found = PooledVerdict(Verdict.NAMED, several, (), (), (), GAP, (GAP,), (np.zeros(1),), nothing).without_names()
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
    case: Any = SimpleNamespace(
        clean=clean, gap=replace(GAP, explained=explained), held_out_effects=found, problem=problem
    )
    assert bool(_small_share_doubt(case)) is little


def test_a_share_is_of_the_recordings_with_a_gap() -> None:
    whole = joint_gap([GAP, replace(OPEN, after_sigma=3.0)])
    assert whole.explained == pytest.approx((10.0**2 - 2.0**2) / (10.0**2 - 1))
    assert joint_gap([OPEN]).explained is None


def test_a_joint_gap_weighs_all_recordings_alike_and_explains_at_most_all() -> None:
    other = GapSize(10.0, 5.0, 3.0, 0.5, 1.0)
    whole = joint_gap([GAP, other])
    sizes = (whole.before_nT, whole.before_sigma, whole.after_nT, whole.after_sigma)
    assert sizes == pytest.approx((250**0.5, 62.5**0.5, 12.5**0.5, 2.125**0.5))
    assert whole.explained == pytest.approx((96.0 + 24.75) / (99.0 + 24.0))
    assert joint_gap([replace(other, after_sigma=0.0)]).explained == 1.0


def test_the_others_coefficients_are_those_of_recordings_that_do_not_lack_the_effect() -> None:
    one, two, four = (CoefficientEstimate(np.eye(1), np.array([c])) for c in (1.0, 2.0, 4.0))
    there = (Presence.PRESENT, Presence.ABSENT, Presence.UNDECIDED, Presence.NOT_RECORDED)
    finding: Any = SimpleNamespace(pooled=SimpleNamespace(estimates=(one, two, four, None)), presence=there)
    assert _predicted_coefficients(finding, 0) == pytest.approx([4.0])
    assert _predicted_coefficients(finding, 2) == pytest.approx([1.0])


def test_surrogates_are_shifted_alike_in_every_recording_and_the_largest_gain_counts() -> None:
    """Products of one column and its target: the other's coefficient g / N explains ``c g - c^2 N / 2``."""

    def shifted(*scores: float) -> Any:
        return SimpleNamespace(surrogates=[np.array([[1.0, g], [g, 9.0]]) for g in scores], inflation=2.0)

    pooled: Any = SimpleNamespace(tested=[shifted(1.0, 3.0, -4.0), shifted(1.0, 2.0, 4.0)])
    # over two: (3, 2) explain 2 * 3 - 2 + 3 * 2 - 4.5 = 5.5 of unit information
    assert _largest_surrogate_gain(pooled) == pytest.approx(5.5 / 2)


def test_settings_are_those_that_a_recording_accepts_else_the_best_that_it_tried() -> None:
    """Each once; an event of one run is no setting of a lot."""

    def evidence(name: str, setting: object, *, one_run: bool = False) -> Any:
        candidate = SimpleNamespace(one_run=one_run, setting=setting)
        return SimpleNamespace(name=name, candidate=candidate)

    drift, tone, other, again, jump = (
        *(evidence("drift", 1), evidence("tone", 2), evidence("tone", 3), evidence("drift", 4)),
        evidence("jump", 5, one_run=True),
    )

    def told(own: tuple[Any, ...], tried: tuple[Any, ...]) -> Any:
        selection = SimpleNamespace(results=[SimpleNamespace(evidence=one) for one in tried])
        return SimpleNamespace(
            own_effects=[SimpleNamespace(evidence=one) for one in own],
            examination=SimpleNamespace(conclusion=SimpleNamespace(selection=selection)),
        )

    found = _settings([told((tone,), (drift, other, jump)), told((tone, other), (drift, again, tone))])
    assert found["tone"] == [tone.candidate, other.candidate]
    assert found["drift"] == [drift.candidate, again.candidate]
    assert "jump" not in found or found["jump"] == []


def test_a_share_of_the_gap_is_of_the_recordings_with_the_effect() -> None:
    """On average a share; none where none has it."""

    def fitted(squares: float) -> Any:
        target = SimpleNamespace(size=100)
        return SimpleNamespace(squares=squares, problem=SimpleNamespace(target=target))

    def explains(*shares: float, there: tuple[Presence, ...]) -> bool:
        problem = SimpleNamespace(policy=STANDARD)
        before: Any = [SimpleNamespace(start=fitted(1100.0), baseline=fitted(900.0), problem=problem) for _ in shares]
        after: Any = [SimpleNamespace(baseline=fitted(900.0 - 1000.0 * share)) for share in shares]
        return bool(_explains_gap(SimpleNamespace(presence=there), before, after))  # type: ignore[arg-type]

    trace = STANDARD.trace
    assert explains(0.5 * trace, 1.6 * trace, there=(Presence.PRESENT,) * 2)
    assert not explains(0.5 * trace, 1.4 * trace, there=(Presence.PRESENT,) * 2)
    assert not explains(0.5 * trace, 9.0 * trace, there=(Presence.PRESENT, Presence.ABSENT))
    assert not explains(0.5, 0.5, there=(Presence.UNDECIDED,) * 2)


def test_look_alikes_of_what_differs_are_those_that_every_recording_with_the_name_lists() -> None:
    def told(**own: tuple[str, ...]) -> Any:
        effects = [SimpleNamespace(name=name, alternatives=listed) for name, listed in own.items()]
        return SimpleNamespace(own_effects=effects)

    recordings = [told(tone=("a", "b", "c")), told(tone=("c", "a"), drift=("x",)), told()]
    assert _common_alternatives("tone", recordings) == ["a", "c"]
    assert _common_alternatives("drift", recordings) == ["x"]
    assert _common_alternatives("scale", recordings) == []
