"""What one cause leaves of another: a recording's own beside the lot's, and names that a lot does not tell apart."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.pooled_effect import CandidateInRecording, PooledEffect
from diagnosis.several.transfer import assess_transfer, fit_equally_well, look_alikes
from sim.effects import EFFECTS
from sim.effects.base import Effect
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
    one = CandidateInRecording.of(one_of_lot, coloured_baseline, coloured_baseline.rows.bin(one_of_lot.columns(here)))
    again = one.beside([own.columns(here)])
    assert one.held_out_gain > STANDARD.coloured_nats
    assert (again is one) is stays
    assert stays or again.held_out_gain < STANDARD.apart
    assert one.beside([]) is one


@pytest.mark.parametrize(("size", "names"), [(0.8, [DRIFT.name]), (8.0, [])])
def test_a_name_lists_what_fits_as_well_whatever_its_search_cost(size: float, names: list[str]) -> None:
    """At a tenth of the noise a drift that was searched for is as good; at its size it is not."""
    problems = [flown("warm", size, seed) for seed in (1, 2)]
    pooled = PooledEffect.beside([WARM], [], problems)
    found = assess_transfer(pooled, STANDARD.apart)
    settings = {WARM.name: [WARM], DRIFT.name: [DRIFT.at({}, tried=10**6)], MOTOR.name: [MOTOR]}
    assert found.transfer is not None
    assert fit_equally_well(found, settings) == names


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
    pooled = PooledEffect.beside([REGIONAL], [], problems)
    settings = {GRADIENT.name: [GRADIENT.at({"origin_enu_m": origin_m})]}
    assert fit_equally_well(assess_transfer(pooled, STANDARD.apart), settings) == names


@pytest.mark.parametrize(("rival", "explained"), [(WARM, True), (RIPPLE, False)])
def test_a_rival_is_explained_that_gains_nothing_beside_the_best(rival: Candidate, explained: bool) -> None:
    """A temperature that rises as a drift does gains alone and not beside it; a tone of its own gains beside it."""
    problems = [flown("both", 40.0, seed) for seed in (1, 2)]
    baselines = [ColouredBaseline.of(one, []) for one in problems]
    best = PooledEffect.of([DRIFT], baselines)
    columns = [baseline.rows.bin(rival.columns(one)) for baseline, one in zip(baselines, problems, strict=True)]
    assert best.explains(dict(enumerate(columns))) is explained
    assert best.explains({0: columns[0]}) is explained
    assert best.explains({})


KIN = [effect for effect in EFFECTS if effect.traits.family][:2]


@dataclass(frozen=True)
class Told:
    """A candidate of a lot with its gain, and whether it leaves nothing of a rival."""

    candidate: Candidate
    gain: float
    useless: bool = True
    columns: None = None
    policy: Policy = STANDARD
    V: float = 5.0 / STANDARD.apart

    @property
    def name(self) -> str:
        return self.candidate.name

    def explains(self, columns: None) -> bool:
        return self.useless


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
    best: type[Effect], other: type[Effect], gain: float, coloured: bool, useless: bool, close: bool, near: bool
) -> None:
    """And gain as much by chance, or but for an error of form: more of kin, and beside a colour."""
    first, second = Told(Candidate(best), 1000.0, useless), Told(Candidate(other), gain)
    closest, others = look_alikes(first, [first, second], coloured=coloured)  # type: ignore[arg-type,list-item]
    assert [one.name for one in closest] == [best.name, *([other.name] if close else [])]
    assert bool(others) is near
