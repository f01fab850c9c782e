"""What several recordings accept together, by what each has by itself."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import CandidateResult, judge_settings
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.pooled_effect import PooledEffect, Presence
from diagnosis.several.selection import PooledRecording, is_form_of, select_pooled
from diagnosis.several.transfer import assess_transfer
from sim.effects import BY_NAME
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIronDrift
from sim.effects.offsets import OffsetJump
from sim.effects.temperature import TemperatureOffset
from tests.diagnosis.synthetic import problem, recording

N = 1200
MOTOR, WARM = Candidate(MotorCurrent), Candidate.of(TemperatureOffset(slope_nT_K=(1.0, 0.5, 0.2)))
DRIFT = Candidate.of(HardIronDrift(rate_nT_h=(100.0, 50.0, 20.0)))
JUMP = Candidate.of(OffsetJump(time_s=40.0, step_nT=(5.0, 0.0, 0.0)))
GAIN = np.array([3.0, -2.0, 4.0])


@cache
def flown(share: float, seed: int) -> LinearProblem:
    """A recording with a share of the motor's field."""
    return problem(recording(N, seed=seed, hidden={"motor_current": {"gain_nT_A": (share * GAIN).tolist()}}))


def member(
    posed: LinearProblem,
    accepted: Sequence[Candidate] = (),
    listed: Sequence[Candidate] = (MOTOR,),
    alternatives: tuple[str, ...] = (),
) -> PooledRecording:
    """A recording whose own diagnosis accepted some candidates, each with look-alikes, and tried others."""
    start = Baseline.of(posed)
    found = {one: judge_settings(start, [one]) for one in (*listed, *accepted)}
    own = [AcceptedEffect(evidence, alternatives) for one in accepted if (evidence := found[one])]
    results = [CandidateResult(evidence, evidence.nats, 0.0, "") for one in listed if (evidence := found[one])]
    selection: Any = SimpleNamespace(accepted=own, start=start, results=results)
    examination: Any = SimpleNamespace(selection=selection, problem=posed)
    return PooledRecording.of(examination)


def selected(*members: PooledRecording) -> list[tuple[str, Transfer | None]]:
    return [(effect.name, effect.transfer) for effect in select_pooled(members, lambda step: None)[0]]


@pytest.mark.parametrize(
    ("shares", "names"),
    [
        ((1.0, 1.0), [("motor_current", Transfer.TRANSFERRED)]),
        ((0.07, 0.07), [("motor_current", Transfer.TRANSFERRED)]),
        ((1.0, 1.5), [("motor_current", Transfer.NOT_TRANSFERRED)]),
        ((1.0, 0.0), []),
        ((0.0, 0.0), []),
    ],
)
def test_an_effect_is_accepted_where_two_recordings_show_it(
    shares: tuple[float, ...], names: list[tuple[str, Transfer]]
) -> None:
    """Weak in each as well; the field of all motors, whichever setting a recording listed first."""
    listed = (MOTOR.at({"motor": 1}), MOTOR)
    own = ([MOTOR] if share > 0.5 else [] for share in shares)
    assert selected(*(member(flown(share, i), next(own), listed) for i, share in enumerate(shares))) == names


@pytest.mark.parametrize(
    ("share", "own", "alternatives", "stands"),
    [
        (1.0, (MOTOR, MOTOR, None), (), True),
        (1.0, (MOTOR, WARM, WARM), (), False),
        (1.0, (MOTOR, WARM, WARM), ("motor_current",), True),
        (0.06, (None, None, None), (), True),
    ],
)
def test_what_half_of_the_recordings_able_to_show_it_do_not_name_is_no_name(
    share: float, own: tuple[Candidate | None, ...], alternatives: tuple[str, ...], stands: bool
) -> None:
    """Their look-alikes are names too; recordings that show hardly anything alone have no say."""
    members = [
        member(flown(share, i), [] if one is None else [one], alternatives=alternatives) for i, one in enumerate(own)
    ]
    assert bool(selected(*members)) is stands


def test_what_one_recording_names_is_told_with_what_the_others_say_and_its_events_stay_with_it() -> None:
    members = [member(flown(1.0, 1), [MOTOR, JUMP]), member(flown(0.0, 2), [])]
    accepted, (alone,) = select_pooled(members, lambda step: None)
    assert accepted == []
    there = {0: Presence.PRESENT, 1: Presence.ABSENT}
    assert (alone.name, alone.transfer, alone.presence) == ("motor_current", None, there)
    assert [len(one.baseline.accepted_columns) for one in members] == [1, 0]


def effect_in(posed: LinearProblem, candidate: Candidate, *accepted: Candidate) -> PooledEffect:
    """An effect in two recordings of one course, beside accepted ones."""
    return assess_transfer(PooledEffect.beside(candidate, accepted, [posed] * 2), 0.0)


def test_what_is_much_smaller_than_alone_looked_like_what_is_in() -> None:
    """A drift beside the temperature that rose, and effects of one family, are forms; a motor's field is none."""
    slope = {TemperatureOffset.name: {"slope_nT_K": [4.0, 2.0, 0.8]}}
    here, both = (
        problem(recording(N, hidden=hidden))
        for hidden in (slope, {**slope, MotorCurrent.name: {"gain_nT_A": GAIN.tolist()}})
    )

    def is_form(posed: LinearProblem, one: PooledEffect, *accepted: PooledEffect) -> bool:
        return is_form_of(accepted, one, [ColouredBaseline.of(posed, [])] * 2)

    warm = effect_in(here, WARM)
    assert is_form(here, effect_in(here, DRIFT, WARM), warm)
    assert not is_form(both, effect_in(both, MOTOR, WARM), effect_in(both, WARM))
    latency, eddy = (Candidate.of(BY_NAME[name](**BY_NAME[name].example)) for name in ("latency", "eddy_current"))
    assert is_form(here, effect_in(here, eddy), effect_in(here, latency))


@pytest.mark.parametrize(("share", "listed"), [(1.5, ["a", "c"]), (1.0, [])])
def test_look_alikes_of_what_differs_are_those_that_every_recording_with_the_name_lists(
    share: float, listed: list[str]
) -> None:
    """Of what is the same in all, the recordings together tell the look-alikes."""
    shares, lists = (1.0, share, 0.0), (("a", "b", "c"), ("c", "a"), ())
    members = [
        member(flown(size, i), [MOTOR] if size else [], alternatives=names)
        for i, (size, names) in enumerate(zip(shares, lists, strict=True))
    ]
    (one,) = select_pooled(members, lambda step: None)[0]
    assert [name for name in one.alternatives if name in "abc"] == listed
