"""What one cause leaves of another: a recording's own beside the lot's, and names that a lot does not tell apart."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.look_alikes import fit_equally_well, is_explained_by
from diagnosis.several.pooled_test import CandidateInRecording, PooledCandidate, with_own_effects
from diagnosis.several.selection import PooledEffect, PooledRecording, _is_contradicted, _is_form_of_accepted
from diagnosis.several.transfer import Presence
from diagnosis.several.transfer import assess_transfer as reached
from sim.effects import BY_NAME
from sim.effects.currents import CurrentRipple, MotorCurrent
from sim.effects.earth import FieldGradient, RegionalField
from sim.effects.iron import HardIronDrift
from sim.effects.temperature import TemperatureOffset
from tests.diagnosis.synthetic import problem, recording

DRIFT = Candidate.of(HardIronDrift(rate_nT_h=(100.0, 50.0, 20.0)))
WARM = Candidate.of(TemperatureOffset(slope_nT_K=(1.0, 0.5, 0.2)))
REGIONAL = Candidate.of(RegionalField(error_enu_nT=(1.0, 1.0, 1.0)))
GRADIENT = Candidate(FieldGradient)
RIPPLE = Candidate.of(CurrentRipple(amplitude_nT_A=(0.2, -0.2, 0.2), frequency_hz=1.3))
MOTOR = Candidate.of(MotorCurrent(gain_nT_A=(1.0, 1.0, 1.0)))


@cache
def flown(hidden: str, size: float, seed: int = 0) -> LinearProblem:
    """Two minutes in which the temperature only rises, as a drift does."""
    tables = {"warm": {WARM.name: {"slope_nT_K": (np.array([1.0, 0.5, 0.2]) * size).tolist()}},
              "drift": {DRIFT.name: {"rate_nT_h": (np.array([90.0, 45.0, 18.0]) * size).tolist()}}}  # fmt: skip
    tables["both"] = {**tables["drift"], RIPPLE.name: {"amplitude_nT_A": [0.2, -0.2, 0.2], "frequency_hz": 1.3}}
    return problem(recording(1200, seed=seed, hidden=tables[hidden]))


@pytest.mark.parametrize(
    ("hidden", "one_of_lot", "own", "stays"),
    [
        ("warm", DRIFT, WARM, False),
        ("warm", DRIFT, MOTOR, True),
        ("drift", DRIFT, WARM, True),
        ("both", RIPPLE, DRIFT, True),
    ],
)
def test_beside_what_a_recording_alone_has_nothing_is_left_of_what_that_takes_up(
    hidden, one_of_lot, own, stays
) -> None:
    here = flown(hidden, 40.0 if hidden == "both" else 4.0)
    coloured_baseline = ColouredBaseline.of(here, [])
    one = CandidateInRecording.of(
        one_of_lot, here, coloured_baseline, coloured_baseline.rows.bin(one_of_lot.columns(here))
    )
    again = with_own_effects(one, [own.columns(here)])
    assert one.held_out_gain > STANDARD.coloured_nats
    assert (again is one) is stays
    assert stays or again.held_out_gain < STANDARD.apart
    assert with_own_effects(one, []) is one


@pytest.mark.parametrize(("size", "names"), [(0.8, [DRIFT.name]), (8.0, [])])
def test_a_name_lists_what_fits_as_well_whatever_its_search_cost(size: float, names: list[str]) -> None:
    """At a tenth of the noise a drift that was searched for is as good; at its size it is not."""
    problems = [flown("warm", size, seed) for seed in (1, 2)]
    pooled = PooledCandidate.of(WARM, [ColouredBaseline.of(one, []) for one in problems], problems, 1)
    found = reached(pooled, STANDARD.apart, STANDARD)
    settings = {WARM.name: [WARM], DRIFT.name: [DRIFT.at({}, tried=10**6)], MOTOR.name: [MOTOR]}
    assert found.transfer is not None
    assert fit_equally_well(found, settings, problems) == names


NEAR_M, FAR_M = (60.0, 0.0, 0.0), (300.0, 0.0, 0.0)
FIELDS = {
    REGIONAL.name: {"error_enu_nT": (0.8, -0.5, 0.6)},
    GRADIENT.name: {
        "gradient_nT_m": ((-0.013, 0.008, -0.01), (0.008, 0.013, 0.0), (-0.01, 0.0, 0.0)),
        "origin_enu_m": NEAR_M,
    },
}


@pytest.mark.parametrize(
    ("hidden", "origin_m", "names"),
    [
        (REGIONAL.name, NEAR_M, []),
        (REGIONAL.name, FAR_M, []),
        (GRADIENT.name, NEAR_M, [GRADIENT.name]),
    ],
)
def test_what_contains_a_name_is_a_look_alike_where_it_fits_better(
    hidden: str, origin_m: Any, names: list[str]
) -> None:
    """Most of a gradient of a place passed at a distance is a constant, but not all: from afar it fits as well."""
    problems = [problem(recording(1200, seed=seed, hidden={hidden: FIELDS[hidden]})) for seed in (1, 2)]
    pooled = PooledCandidate.of(REGIONAL, [ColouredBaseline.of(one, []) for one in problems], problems, 1)
    settings = {GRADIENT.name: [GRADIENT.at({"origin_enu_m": origin_m})]}
    assert fit_equally_well(reached(pooled, STANDARD.apart, STANDARD), settings, problems) == names


@pytest.mark.parametrize(
    ("own", "named", "refused"),
    [
        ((99.0, 120.0, -6.0), ((), ("current_ripple",), ()), True),
        ((99.0, 120.0, -6.0), (("current_ripple",), ("current_ripple",), ()), False),
        ((99.0, 120.0, 80.0), (("current_ripple",), ("motor_current",), ()), False),
        ((9.0, 12.0, 8.0), ((), (), ()), False),
    ],
)
def test_what_half_of_the_recordings_refuse_by_themselves_is_no_name(own, named, refused) -> None:
    pooled: Any = SimpleNamespace(own_nats=own.__getitem__, policy=STANDARD)
    one: Any = SimpleNamespace(
        name="current_ripple", alternatives=("motor_current",), finding=SimpleNamespace(pooled=pooled)
    )
    recordings: Any = [SimpleNamespace(own_names=set(names)) for names in named]
    assert _is_contradicted(one, recordings) is refused


def test_what_is_much_smaller_than_alone_looked_like_what_is_in() -> None:
    here = flown("warm", 4.0)
    alone, coloured_baseline = (
        ColouredBaseline.of(here, accepted_columns) for accepted_columns in ([], [WARM.columns(here)])
    )
    joints = (PooledCandidate.of(DRIFT, [each] * 2, [here] * 2, 1) for each in (coloured_baseline, alone))
    one, other = (PooledEffect(reached(pooled, 0.0, STANDARD), ()) for pooled in joints)
    assert one.strength < STANDARD.half * other.strength
    assert one.without_others([alone] * 2).strength == other.strength


@pytest.mark.parametrize(("alone", "is_form"), [(0.35, False), (1.1, True)])
def test_a_third_of_the_first_is_its_form_only_where_it_looked_like_it(alone: float, is_form: bool) -> None:
    def chosen(effect: Candidate, strength: float) -> Any:
        pooled = SimpleNamespace(candidate=effect)
        found = SimpleNamespace(name=effect.name, strength=strength, finding=SimpleNamespace(pooled=pooled))
        found.without_others = lambda first: SimpleNamespace(strength=alone)
        return found

    assert _is_form_of_accepted(chosen(DRIFT, 0.3), [chosen(WARM, 0.92)], [], STANDARD) is is_form


def test_what_is_of_one_kin_is_not_held_against_it() -> None:
    latency, eddy = (Candidate(BY_NAME[name]) for name in ("latency", "eddy_current"))
    own: Any = SimpleNamespace(name="latency", alternatives=(), evidence=SimpleNamespace(candidate=latency))
    own.columns = lambda given: np.zeros((1, 1, 1))
    recording: Any = SimpleNamespace(own_effects=[own], problem=None)
    in_recording = [
        PooledRecording.competing_columns(recording, SimpleNamespace(name=one.name, candidate=one))
        for one in (latency, eddy, DRIFT)
    ]  # type: ignore[arg-type]
    assert [len(one) for one in in_recording] == [0, 0, 1]


@pytest.mark.parametrize(("rival", "explained"), [(WARM, True), (RIPPLE, False)])
def test_a_rival_is_explained_that_gains_nothing_beside_the_best(rival: Candidate, explained: bool) -> None:
    """A temperature that rises as a drift does gains alone and not beside it; a tone of its own gains beside it."""
    problems = [flown("both", 40.0, seed) for seed in (1, 2)]
    baselines = [ColouredBaseline.of(one, []) for one in problems]
    best = PooledCandidate.of(DRIFT, baselines, problems, 1)
    columns = [baseline.rows.bin(rival.columns(one)) for baseline, one in zip(baselines, problems, strict=True)]
    assert bool(is_explained_by(columns, best)) is explained
    assert bool(is_explained_by([columns[0], None], best)) is explained
    assert is_explained_by([None, None], best)


def test_the_strength_of_a_lot_is_that_of_the_recordings_with_the_effect() -> None:
    """The root of the mean square; of all that were asked where none has it."""

    def strength(*there: Presence) -> float:
        in_recordings = (SimpleNamespace(strength=3.0), SimpleNamespace(strength=4.0), None)
        pooled: Any = SimpleNamespace(in_recordings=in_recordings, tested=in_recordings[:2])
        finding: Any = SimpleNamespace(pooled=pooled, presence=there)
        return PooledEffect(finding, ()).strength

    here, absent, unasked = Presence.PRESENT, Presence.ABSENT, Presence.NOT_RECORDED
    assert strength(here, here, unasked) == pytest.approx(12.5**0.5)
    assert strength(here, absent, unasked) == pytest.approx(3.0)
    assert strength(absent, Presence.UNDECIDED, unasked) == pytest.approx(12.5**0.5)


def test_an_effect_has_no_strength_beyond_those_that_show_it() -> None:
    """A recording that is not asked has none to give."""
    pooled: Any = SimpleNamespace(in_recordings=(None, SimpleNamespace(strength=2.0)), tested=())
    finding: Any = SimpleNamespace(pooled=pooled, presence=(Presence.PRESENT, Presence.PRESENT))
    assert PooledEffect(finding, ()).strength == 2.0
