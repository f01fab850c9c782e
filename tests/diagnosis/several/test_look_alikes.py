"""What one cause leaves of another: a recording's own beside the lot's, and names that a lot does not tell apart."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.pooled_effect import CandidateInRecording, PooledEffect
from diagnosis.several.selection import fit_equally_well
from diagnosis.several.transfer import assess_transfer
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
    ("hidden", "one_of_lot", "own", "keeps"),
    [
        ("warm", DRIFT, WARM, False),
        ("warm", DRIFT, MOTOR, True),
        ("drift", DRIFT, WARM, True),
        ("both", RIPPLE, DRIFT, True),
    ],
)
def test_beside_what_a_recording_alone_has_nothing_is_left_of_what_that_takes_up(
    hidden, one_of_lot, own, keeps
) -> None:
    """A temperature takes up a drift of its course; what is not there, or has another course, leaves the candidate."""
    here = flown(hidden, 40.0 if hidden == "both" else 4.0)
    coloured_baseline = ColouredBaseline.of(here, [])
    one = CandidateInRecording.of(one_of_lot, coloured_baseline, coloured_baseline.rows.bin(one_of_lot.columns(here)))
    again = one.beside([own.columns(here)])
    assert one.held_out_gain > STANDARD.coloured_nats
    assert again.held_out_gain > STANDARD.coloured_nats if keeps else again.held_out_gain < STANDARD.apart
    assert one.beside([]) is one


@pytest.mark.parametrize(("size", "names"), [(0.8, [DRIFT.name]), (8.0, [])])
def test_a_name_lists_what_fits_as_well_whatever_its_search_cost(size: float, names: list[str]) -> None:
    """At a tenth of the noise a drift that was searched for is as good; at its size it is not."""
    problems = [flown("warm", size, seed) for seed in (1, 2)]
    pooled = PooledEffect.beside(WARM, [], problems)
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
    pooled = PooledEffect.beside(REGIONAL, [], problems)
    settings = {GRADIENT.name: [GRADIENT.at({"origin_enu_m": origin_m})]}
    assert fit_equally_well(assess_transfer(pooled, STANDARD.apart), settings) == names
