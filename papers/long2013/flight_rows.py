"""Trials and rows of [Long2013]'s calibration from motions flown in the engine: turntable, AUV, quadrotor.

The paper turns its sensor by a whole turn about each axis. A turntable can; an AUV pitches and rolls by some 20 degrees
and a quadrotor sways, and the attitude that aligns (eq. 12) is navigation's.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from calib import Reference
from calib.methods.ml_newton import MaximumLikelihoodNewton
from papers.base import PaperRow
from papers.flights import bare, flight
from papers.judgement import claim
from papers.long2013.rows import LIMIT_PITCH_DEG, LIMIT_ROLL_DEG, LIMIT_SHARE, NOISE_NT, worst_text
from papers.long2013.trials import (
    NED_TO_ENU,
    STRENGTH_NT,
    attitude_errors_deg,
    effects,
    field_ned_nT,
    measured,
    offset_nT,
    rolling,
    state_of,
)
from scenarios.arrays import Array
from sim.scenario import Scenario

TURNTABLE, AUV, QUADROTOR = "turntable's three turns", "AUV's excited circles", "quadrotor swaying on the spot"
VEHICLES = (TURNTABLE, AUV, QUADROTOR)


@dataclass(frozen=True)
class FlownCalibration:
    """Results of a noise seed on a flown motion: status of the fit, and errors.

    own_pct, test_pct: largest deviation of the corrected strength along the flight, and along the rolling test, %;
    roll_deg, pitch_deg: largest errors in the test; offset_nT: error of the hard iron.
    """

    status: str
    own_pct: float
    test_pct: float
    roll_deg: float
    pitch_deg: float
    offset_nT: float


def scenario_of(vehicle: str) -> Scenario:
    """Return a vehicle's scenario in the paper's field, with 1200 to 1800 samples."""
    table = bare("turntable-three-turns")
    if vehicle == TURNTABLE:
        return table
    if vehicle == AUV:
        return bare("auv-spiral-excited", ["sampling.rate_hz=1"], field=table.field)
    sway = bare("quad-calibration", ["sampling.rate_hz=5"], field=table.field)
    return sway.model_copy(update={"phases": sway.phases[1:2]})


def flight_trial(task: tuple[str, int]) -> list[FlownCalibration]:
    """Fly a vehicle once; per noise seed add the printed errors, calibrate, and roll once on the turntable.

    task : vehicle, number of seeds
    """
    vehicle, seeds = task
    flown = flight(scenario_of(vehicle), 0)
    reference = Reference.of_vector(tuple((NED_TO_ENU @ field_ned_nT()).tolist()))
    chain, test = effects(1.0, NOISE_NT), state_of(rolling())
    found = []
    for seed in range(seeds):
        turns = replace(measured(flown.state, chain, 2 * seed), att_q=flown.measured.att_q)
        rolled = measured(test, chain, 2 * seed + 1)
        fit = MaximumLikelihoodNewton().fit(turns, reference)
        roll_deg, pitch_deg = np.abs(attitude_errors_deg(fit.apply(rolled))).max(axis=0)
        error_nT = float(np.linalg.norm(fit.offset_nT - offset_nT()))
        own, other = (_deviation_pct(fit.apply(one)) for one in (turns, rolled))
        found.append(FlownCalibration(fit.status.kind, own, other, float(roll_deg), float(pitch_deg), error_nT))
    return found


def _deviation_pct(field_nT: Array) -> float:
    return float(100.0 * np.abs(np.linalg.norm(field_nT, axis=1) / STRENGTH_NT - 1.0).max())


def flight_rows(runs: dict[str, list[FlownCalibration]]) -> list[PaperRow]:
    """Return the rows of each vehicle beside the kinematic ones; runs: by vehicle, a calibration per seed."""
    return [row for vehicle, found in runs.items() for row in _vehicle(vehicle, found)]


def _vehicle(vehicle: str, found: list[FlownCalibration]) -> list[PaperRow]:
    kinds = ", ".join(f"{count} {kind}" for kind, count in Counter(one.status for one in found).items())
    offset = np.array([one.offset_nT for one in found])
    own = np.array([one.own_pct for one in found])
    note = (
        f"calibrated from the flight, tried on the rolling test; noise {NOISE_NT:g} nT; fits: {kinds}; hard iron wrong "
        f"by {worst_text(offset, 'nT', 0)}"
    )
    along = f"along the flight itself {worst_text(own, '%')}. {note}"
    figures = (
        ("largest deviation of the corrected field strength", "within 2 %", "test_pct", 100 * LIMIT_SHARE, "%", along),
        ("largest roll error", "1 degree", "roll_deg", LIMIT_ROLL_DEG, "degrees", note),
        ("largest pitch error", "2.2 degrees", "pitch_deg", LIMIT_PITCH_DEG, "degrees", note),
    )
    return [
        _row(f"{vehicle} flown: {what}", paper, np.array([getattr(one, name) for one in found]), limit, unit, text)
        for what, paper, name, limit, unit, text in figures
    ]


def _row(what: str, paper: str, values: Array, limit: float, unit: str, note: str) -> PaperRow:
    judged = claim(values.max() <= limit, f"worst seed at most {limit:g} {unit}", "printed as a limit")
    return PaperRow(what, paper, worst_text(values, unit), judged, note)
