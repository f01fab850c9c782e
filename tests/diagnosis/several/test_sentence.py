"""What is said of several recordings and of the sensors of an array, from findings that are told."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis.evidence.localise import ChannelShare
from diagnosis.result import EvidenceKind, Transfer
from diagnosis.several.result import SENSORS
from diagnosis.several.sentence import (
    describe_transfer,
    headline_sentence,
    pooled_advice,
    pooled_sentence,
)
from diagnosis.verdict import Verdict
from sim.effects.offsets import OffsetJump
from tests.diagnosis.several.told import ABSENT, GAP, HERE, OPEN, common, gap, iron, motor, own, pooled

ALL, DIFFERS, SOME = Transfer.TRANSFERRED, Transfer.NOT_TRANSFERRED, Transfer.SOME


@pytest.mark.parametrize(
    ("transfer", "presence", "words", "of_sensors"),
    [
        (ALL, (HERE, HERE, HERE), "the same in all 3 recordings", "the same in all 3 sensors"),
        (DIFFERS, (HERE, HERE, HERE), "of different size from recording to recording", "from sensor to sensor"),
        (SOME, (HERE, ABSENT, HERE), "in 2 of 3 recordings", "in 2 of 3 sensors"),
        (Transfer.SINGLE_RUN, (HERE, OPEN, ABSENT), "in 1 of 3 recordings", "in 1 of 3 sensors"),
    ],
)
def test_how_far_an_effect_reaches_in_words(transfer, presence, words, of_sensors) -> None:  # type: ignore[no-untyped-def]
    effect = common(transfer, presence)
    assert describe_transfer(effect) == words
    assert of_sensors in describe_transfer(effect, SENSORS)


def test_the_sentence_names_effect_reach_and_share() -> None:
    found = pooled_sentence(pooled(common(ALL)))
    assert found == (
        "Missing in the model: motor_current: gain_nT_A (3, 0, 0) nT/A, 2 times the noise, the same in all 3 "
        "recordings; in each recording the others' coefficients explain 92 % of the gap; the residual is clean."
    )
    both = pooled_sentence(pooled(common(DIFFERS), common(ALL)))
    assert both.count("motor_current") == 2
    assert "the others' coefficients" in both
    assert "in each recording its own coefficients explain 92 %" in pooled_sentence(pooled(common(DIFFERS)))


@pytest.mark.parametrize(
    ("size", "kind"), [(replace(GAP, explained=None), EvidenceKind.HELD_OUT), (GAP, EvidenceKind.SPECTRUM)]
)
def test_a_share_is_told_where_a_fitted_effect_explains_a_gap(size, kind) -> None:  # type: ignore[no-untyped-def]
    effect = replace(common(ALL), named=motor(kind=kind))
    assert "explain" not in pooled_sentence(pooled(effect, gaps=(gap(size),) * 3))
    none_of_it = pooled_sentence(pooled(common(ALL), gaps=(gap(replace(GAP, after_sigma=10.0, explained=0.0)),) * 3))
    assert "explain 0 % of the gap" in none_of_it


def test_what_is_left_and_the_first_three_channels_are_told_where_nothing_explains() -> None:
    where = [ChannelShare(f"c{k}", "body", 0.3 - 0.01 * k) for k in range(5)]
    gaps = (gap(where=where, left=("slow",)), gap(), gap(left=("fast",)))
    found = pooled_sentence(pooled(verdict=Verdict.UNKNOWN, gaps=gaps))
    assert found.startswith("No effect of the library explains the gap well enough (first: slow; third: fast)")
    assert found.endswith("; the gap follows c0, c1, c2.")
    assert "follows" not in pooled_sentence(pooled(verdict=Verdict.UNKNOWN))


def test_events_of_one_recording_are_told_beside() -> None:
    """An effect that holds through a run is none, nor is what no fit tells."""
    jump = replace(motor(), effect=OffsetJump(time_s=40.0, step_nT=(5.0, 0.0, 0.0)))
    direct = replace(jump, kind=EvidenceKind.DIRECT)
    each = (own(named=(motor(),)), own(named=(motor(), jump)), own(named=(direct,)))
    found = pooled_sentence(pooled(common(ALL), each=each))
    assert "second alone has offset_jump at 40.00 s: step_nT (5, 0, 0) nT, 2 times the noise." in found
    assert found.count("alone has") == 1


def test_advice_of_all_recordings_is_given_once_and_not_of_what_is_named() -> None:
    lines = ("measure again", "motor_current: move it", "use --confirm", "only here")
    each = (own(advice=lines), own(advice=lines[:3]), own(advice=("x", *lines[:3])))
    assert pooled_advice(pooled(common(ALL), each=each)) == ("measure again",)
    assert pooled_advice(pooled(each=each)) == ("measure again", "motor_current: move it")


def test_advice_says_what_differs_most_and_where_an_effect_is_not() -> None:
    ratios = ((1.02, 0.1), (1.5, 0.1), (0.4, 0.5))
    (line,) = pooled_advice(pooled(common(DIFFERS, ratios=ratios)))
    assert line.startswith("motor_current does not transfer: second has 1.5 times the size of the others (+-0.2).")
    (line,) = pooled_advice(pooled(common(DIFFERS, ratios=(None, (0.5, 0.01), (1.5, 0.1)))))
    assert "second has 0.5 times" in line
    (line,) = pooled_advice(pooled(common(DIFFERS, ratios=(None, None, None))))
    assert line.startswith("motor_current does not transfer. Find out what changed")
    (line,) = pooled_advice(pooled(common(SOME, (HERE, ABSENT, OPEN))))
    assert line.startswith("motor_current is not in second: find out")
    assert pooled_advice(pooled(common(SOME, (HERE, HERE, OPEN)))) == ()


def test_what_one_recording_alone_names_is_contradicted_or_open() -> None:
    contradicted, open_ = (common(Transfer.SINGLE_RUN, (HERE, there, OPEN)) for there in (ABSENT, OPEN))
    assert pooled_advice(pooled(single=(contradicted,))) == (
        "motor_current is named by one recording alone and second contradict it: not a common finding.",
    )
    (line,) = pooled_advice(pooled(single=(open_,)))
    assert "and the others cannot decide: not" in line


def test_the_headline_is_the_worst_sensor_s_with_the_verdicts_of_all() -> None:
    each = (own(), own(Verdict.UNKNOWN), own(Verdict.NAMED))
    found = headline_sentence(pooled(common(ALL), each=each, scope=SENSORS, verdict=Verdict.UNKNOWN, first=1))
    assert found == (
        "second, of 3 sensors (1 none, 1 unknown, 1 named): it is unknown. motor_current is the same in all 3 sensors."
    )
    alike = headline_sentence(pooled(scope=SENSORS, verdict=Verdict.NONE, first=0))
    assert alike == "All 3 sensors: it is none."
    named = pooled(each=(own(Verdict.NAMED),) * 3, scope=SENSORS, verdict=Verdict.NAMED, first=2)
    assert headline_sentence(named) == "third, of 3 sensors (3 named): it is named."
    mixed = pooled(each=(own(), own(), own(Verdict.NAMED)), scope=SENSORS, verdict=Verdict.NONE, first=0)
    assert headline_sentence(mixed).startswith("first, of 3 sensors (2 none, 1 named): ")


def test_what_sensors_share_is_far_and_what_differs_is_near() -> None:
    told = {"scope": SENSORS, "first": 1, "each": (own(), own(advice=("own", "own")), own(advice=("other",)))}
    far, own_advice = pooled_advice(pooled(common(ALL), **told))
    assert "is the same at all sensors: its source is far away" in far
    assert own_advice == "own"
    (near, _) = pooled_advice(pooled(common(DIFFERS, gains=(6.0, None, -2.0)), **told))
    assert near.endswith("or inside each sensor. third has least, first 3 times as much.")
    (nothing, _) = pooled_advice(pooled(common(DIFFERS, gains=(6.0, 0.0, 2.0)), **told))
    assert nothing.endswith("second has least, first most.")
    (some, _) = pooled_advice(pooled(common(SOME, (HERE, ABSENT, ABSENT)), **told))
    assert some == "motor_current is not in second, third: its source is near or inside the other sensors."
    assert pooled_advice(pooled(common(SOME, (HERE, HERE, OPEN)), **told)) == ("own",)
    (single, _) = pooled_advice(pooled(single=(common(Transfer.SINGLE_RUN, (HERE, ABSENT, OPEN)),), **told))
    assert single.startswith("motor_current is not in second: ")


def test_an_effect_that_looks_like_another_is_told_apart_once() -> None:
    alike = replace(common(ALL), named=replace(iron(), alternatives=("sensor_offset",)))
    lines = pooled_advice(pooled(alike, alike))
    assert len(lines) == 1
    assert lines[0].startswith("hard_iron may also be sensor_offset. To distinguish: ")
