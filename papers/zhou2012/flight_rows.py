"""Trials and rows of [Zhou2012]'s twelve stops flown in the engine: turntable, AUV that holds, quadrotor that yaws."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from calib.methods.de_turntable import DeTurntable
from calib.models.turntable import NAMES
from papers.attitudes import state_at_attitudes
from papers.base import PaperRow, spread_text
from papers.flights import bare, flight
from papers.judgement import claim
from papers.zhou2012.trials import NOISE_NT, PRINTED, SEED, STOPS, bound, recording, reference, stops
from scenarios.arrays import Array
from scenarios.paths.hover import Rotate
from scenarios.paths.poses import Pose, Poses
from scenarios.seeds import stream
from sim.scenario import Scenario
from sim.state import State
from validation.text import figure

TURNTABLE, AUV, QUADROTOR = "turntable that rests", "AUV that holds each heading", "quadrotor that yaws in wind"
VEHICLES = (TURNTABLE, AUV, QUADROTOR)
CYCLE_S, END_S = {TURNTABLE: 25.0, AUV: 45.0, QUADROTOR: 5.0}, {TURNTABLE: 19.9, AUV: 44.9, QUADROTOR: 10.0}
"""Time from stop to stop, and of the first sample: the end of a rest; in the quadrotor's even turn, after its start."""
MOVE_S, HOLD_S = 15.0, 30.0
NOTES = {
    TURNTABLE: "the engine's turntable comes to rest at each stop",
    AUV: "an even current, no waves: the hull comes to rest level",
    QUADROTOR: "the model takes every stop for level: a lean that gusts change passes for the sensor's own",
}
TURN_DEG_S = -360.0 / STOPS / CYCLE_S[QUADROTOR]
LEVEL = 3.0
"""Ratio of errors to the bound beyond which more than noise is in the five: three times any seed's scatter."""


@dataclass(frozen=True)
class FlownStops:
    """Results of a seed: errors of the five (5,), their claimed deviations (5,), status, largest lean, range of z."""

    error: Array
    claimed: Array
    status: str
    lean_deg: float
    flat_nT: float


def scenario_of(vehicle: str) -> Scenario:
    """Return a vehicle's scenario in the field of the turntable's, ten samples a second."""
    table = bare("turntable-twelve-stops")
    if vehicle == TURNTABLE:
        return table
    rate = ["sampling.rate_hz=10"]
    if vehicle == AUV:
        headings = (180.0 - (30.0 * k + 180.0) % 360.0 for k in range(STOPS))
        poses = tuple(Pose(yaw_deg=yaw, move_s=MOVE_S, hold_s=HOLD_S) for yaw in headings)
        return bare("auv-spiral", rate, field=table.field, phases=(Poses(kind="poses", poses=poses),))
    turn = Rotate(kind="rotate", duration_s=120.0, turn_rate_deg_s=TURN_DEG_S, tilt_amplitude_deg=0.0)
    return bare("quad-calibration", rate, field=table.field, phases=(turn,))


@lru_cache(maxsize=8)
def flown_stops(vehicle: str, gusts: int) -> State:
    """Return the true state at the twelve stops."""
    state = flight(scenario_of(vehicle), gusts).state
    at_s = END_S[vehicle] + CYCLE_S[vehicle] * np.arange(STOPS)
    rows = np.searchsorted(state.time_s, at_s - state.interval_s / 2)
    return state_at_attitudes(state.R_wb[rows], state.field_enu_nT)


def flight_trial(task: tuple[str, int]) -> FlownStops:
    """Measure at a vehicle's stops by the printed axes with fresh noise, and search; the quadrotor meets other gusts.

    task : vehicle, seed
    """
    vehicle, seed = task
    state = flown_stops(vehicle, seed if vehicle == QUADROTOR else 0)
    measured = recording(state, seed)
    fit = DeTurntable(most_wobble=1.0).fit(measured, reference(state), stream(SEED, seed, "search"))
    assert fit.covariance is not None
    return FlownStops(
        np.array([fit.parameters[name] for name in NAMES]) - PRINTED,
        np.sqrt(np.diag(fit.covariance)),
        fit.status.kind,
        float(np.degrees(np.arccos(np.clip(state.R_wb[:, 2, 2], -1.0, 1.0))).max()),
        float(np.ptp(fit.apply(measured)[:, 2])),
    )


def flight_rows(runs: dict[str, list[FlownStops]]) -> list[PaperRow]:
    """Return two rows of each vehicle beside the kinematic ones; runs: by vehicle, a result per seed."""
    return [row for vehicle, found in runs.items() for row in (_values(vehicle, found), _flat(vehicle, found))]


def _values(vehicle: str, found: list[FlownStops]) -> PaperRow:
    rms = np.sqrt(np.mean([one.error**2 for one in found], axis=0))
    ratio = rms / bound(stops())
    claimed = np.sqrt(np.mean([(one.error / one.claimed) ** 2 for one in found]))
    ok = sum(one.status == "ok" for one in found)
    return PaperRow(
        f"{vehicle}, twelve stops flown: the five found again, rms error",
        ", ".join(f"{value:g}" for value in PRINTED),
        ", ".join(f"{name} {figure(value, 2)}" for name, value in zip(NAMES, rms, strict=True)),
        claim(
            ratio.max() < LEVEL,
            f"{LEVEL:g} times the Cramer-Rao bound of a level turn",
            "the kinematic rows lie within 1.2 times; the rest is the vehicle's",
        ),
        f"{', '.join(figure(r, 2) for r in ratio)} times the bound at {NOISE_NT:g} nT; "
        f"{figure(claimed, 2)} times the fit's own deviations; {ok} of {len(found)} report ok; largest lean "
        f"{spread_text([one.lean_deg for one in found], 'degrees')}. {NOTES[vehicle]}",
    )


def _flat(vehicle: str, found: list[FlownStops]) -> PaperRow:
    flat = np.array([one.flat_nT for one in found])
    return PaperRow(
        f"{vehicle}, twelve stops flown: z output after, largest less smallest",
        "flat after (figure, no number)",
        spread_text(flat, "nT"),
        claim(
            np.median(flat) < 4.0 * NOISE_NT, f"{4.0 * NOISE_NT:g} nT", "the range of twelve noises is 3.3 times one"
        ),
        f"noise of {NOISE_NT:g} nT alone gives 3.3 nT",
    )
