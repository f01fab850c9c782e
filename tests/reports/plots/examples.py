"""One example of every plot of the project, by module and function: a new plot joins by one line."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import diagnose_together
from papers.ding2021 import figures as ding2021
from papers.li2017 import figures as li2017
from papers.li2017.trials import simulated
from papers.long2013 import figures as long2013
from papers.long2013.trials import LongTask
from papers.long2013.trials import calibration_trial as long_trial
from papers.zhang2018 import figures as zhang2018
from papers.zhang2018.trials import DRIFTS, FITS, MAIN, METHODS, POSITIONS, SHORT, DriftTrial, ZhangTrial
from papers.zhou2012 import figures as zhou2012
from papers.zhou2012.trials import ZhouTask, stops
from papers.zhou2012.trials import search_trial as zhou_trial
from reports.plots import (
    bound,
    calibration,
    channel_curves,
    comparison,
    diagnosis,
    effects,
    field,
    gates,
    inspection,
    motion,
    plan,
    pooled,
    recording,
)
from reports.presentation.channel_curves import channel_curves as curves_of
from reports.presentation.diagnosis import PresentedDiagnosis
from reports.presentation.pooled import PresentedPool
from scenarios.sweep import parse_sweep
from sim.effects.channels import ChannelEffect
from sim.scenario import load
from tests.diagnosis.several.test_workflow import MODEL, NAMES, motor, problem_of
from tests.reports.outcome_example import example_outcome
from tests.validation.comparison.example import table_of
from tests.validation.gates.conftest import Scripted, gate_text, groups_in, row
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise, rounded, sensor_data
from validation.bound.query import BoundQuery, WhatIf
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_outcome import GateOutcome
from validation.gates.runner import decide_gates
from validation.inspection.sensor_data import SensorData
from validation.planning.manoeuvre import Leg
from validation.planning.plan import Plan, _flown
from validation.planning.search import LegSelection
from validation.planning.task import PlanningTask
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.outcome import Outcome

SCORE = SCORE_DEFINITIONS["offset_error"]
CHANNEL_EFFECT: Any = ChannelEffect(**ChannelEffect.example)
LEG = SimpleNamespace(choice=SimpleNamespace(phase=SimpleNamespace(duration_s=60.0)), after=4.0)
LEGS: Any = SimpleNamespace(
    legs=(LEG, LEG), idle=LEG, task=SimpleNamespace(goal=SimpleNamespace(short="offset", unit="nT"))
)
CURVE = SimpleNamespace(effect=CHANNEL_EFFECT, covariance=np.eye(9))
CURVED: Any = SimpleNamespace(of_kind=lambda kind: [CURVE], problem=SimpleNamespace(mode="strength"))
CURVES: Any = SimpleNamespace(curves=curves_of(CURVED))


@cache
def outcome() -> Outcome:
    return example_outcome(3000)


@cache
def log() -> SensorData:
    """A log with a tone, a gap and a coarse converter."""
    moving = moved(4000, rate_hz=40.0)
    tone = 8.0 * np.sin(2 * np.pi * 13.0 * moving.time_s)[:, None] * [1.0, 0.0, 0.0]
    mag_nT = rounded(moving.body(FIELD_ENU_NT) + noise(4000, 5.0) + tone, 15.0)
    keep = np.delete(np.arange(4000), slice(2000, 2200))
    return sensor_data(moving.time_s[keep], mag_nT[keep], q=moving.q[keep])


@cache
def pool() -> PooledDiagnosis:
    hidden = [motor(1.0), motor(1.3)]
    return diagnose_together(NAMES[:2], [problem_of(json.dumps(one), i) for i, one in enumerate(hidden)], MODEL)


@cache
def presented() -> PresentedPool:
    return PresentedPool.of(pool())


def single() -> PresentedDiagnosis:
    return presented().each[0]


@cache
def table() -> TrialTable:
    good = np.random.default_rng(9).lognormal(0.0, 0.1, 40)
    points = [{"good": k * good, "poor": 5 * k * good, "uncorrected": 900 * k * good} for k in (1.0, 4.0)]
    return table_of(*points, sweep=[10.0, 40.0])


@cache
def what_if() -> WhatIf:
    scenario = load("standard-auv", ["phases.0.duration_s=120"])
    return WhatIf.of(BoundQuery(), scenario, parse_sweep("pitch_amplitude_deg=0:40:40", scenario, "--what-if"))


@cache
def gate() -> GateOutcome:
    values = np.random.default_rng(4).lognormal(0.0, 0.5, 400)
    with tempfile.TemporaryDirectory() as place:
        groups = groups_in(Path(place) / "gates.toml", gate_text("near", limit=1.5, max_trials=60))
    return decide_gates(groups, Scripted(lambda group, search_trial: [row("ellipsoid", values[search_trial])]))[0]


@cache
def flight_plan() -> Plan:
    """A quadrotor's, whose best attitudes in place are drawn as rings: of three legs that no search has found."""
    task = PlanningTask.of("quadrotor", load("standard-full", ["sampling.rate_hz=5"]), noise_std_nT=10.0)
    legs = tuple(Leg(yaw, pitch, roll, 1.0) for yaw, pitch, roll in ((0, 15, 5), (90, -15, 10), (180, 5, -15)))
    return _flown(LegSelection(task, legs, 60.0, 1.0), None)


class Histories(dict[Any, Any]):
    """The same search history for every task of [Ding2021]."""

    def get(self, key: Any, default: Any = None) -> Any:
        return {"history": np.geomspace(1e4, 1e-5, 50)}

    __getitem__ = get


def zhang_trials() -> list[ZhangTrial]:
    keys = [(setting, name) for setting in (MAIN, SHORT) for name in METHODS]
    errors = {key: np.linspace(-30.0, 30.0, POSITIONS) for key in keys}
    return [ZhangTrial(np.full(POSITIONS, 200.0), errors, {k: seed * np.geomspace(90, 3, 50) for k in keys}, {})
            for seed in (1, 2)]  # fmt: skip


def zhang_drift() -> DriftTrial:
    values = {name: tuple(1.0 + k for k in range(len(DRIFTS))) for name in FITS}
    return DriftTrial(values, values, {})


def before_after() -> tuple[Any, Any, Any, float]:
    """Times, raw field, half of it for the corrected one, and a strength."""
    measured = outcome().recording
    return measured.time_s, measured.mag_nT, 0.5 * measured.mag_nT, 5e4


EXAMPLES: dict[str, Callable[[], Figure]] = {
    "bound.draw_offset": lambda: bound.draw_offset(what_if()),
    "bound.draw_components": lambda: bound.draw_components(what_if().answers[-1]),
    "bound.draw_score_bounds": lambda: bound.draw_score_bounds(what_if()),
    "calibration.draw_strength_before_after": lambda: calibration.draw_strength_before_after(*before_after()),
    "channel_curves.draw_curves": lambda: channel_curves.draw_curves(CURVES),
    "comparison.draw_over": lambda: comparison.draw_over(table(), SCORE, "effects.white_noise.std_nT"),
    "comparison.draw_distributions": lambda: comparison.draw_distributions(table(), SCORE, 0),
    "comparison.draw_ranks": lambda: comparison.draw_ranks(table(), SCORE, 0),
    "diagnosis.draw_gap": lambda: diagnosis.draw_gap(single()),
    "diagnosis.draw_map": lambda: diagnosis.draw_map(single()),
    "diagnosis.draw_spectrum": lambda: diagnosis.draw_spectrum(single()),
    "diagnosis.draw_channel": lambda: diagnosis.draw_channel(single()),
    "diagnosis.draw_ranking": lambda: diagnosis.draw_ranking(single()),
    "effects.draw_effect_sizes": lambda: effects.draw_effect_sizes(outcome()),
    "effects.draw_effects": lambda: effects.draw_effects(outcome()),
    "field.draw_sphere": lambda: field.draw_sphere(outcome()),
    "field.draw_clouds": lambda: field.draw_clouds({"raw": outcome().recording.mag_nT}, 5e4),
    "field.draw_norm": lambda: field.draw_norm(outcome()),
    "field.draw_residuals": lambda: field.draw_residuals(outcome()),
    "gates.draw_gate_course": lambda: gates.draw_gate_course(gate()),
    "inspection.draw_coverage": lambda: inspection.draw_coverage(log()),
    "inspection.draw_directions": lambda: inspection.draw_directions(outcome().recording.mag_nT),
    "inspection.draw_strength": lambda: inspection.draw_strength(log()),
    "inspection.draw_residual": lambda: inspection.draw_residual(log()),
    "inspection.draw_spectrum": lambda: inspection.draw_spectrum(log()),
    "inspection.draw_allan": lambda: inspection.draw_allan(log()),
    "inspection.draw_low_digits": lambda: inspection.draw_low_digits(log()),
    "motion.draw_path": lambda: motion.draw_path(outcome()),
    "motion.draw_vehicle": lambda: motion.draw_vehicle(outcome()),
    "plan.draw_angles": lambda: plan.draw_angles(flight_plan()),
    "plan.draw_gains": lambda: plan.draw_gains(LEGS),
    "plan.draw_design": lambda: plan.draw_design(flight_plan()),
    "pooled.draw_coefficients": lambda: pooled.draw_coefficients(presented(), presented().common[0]),
    "pooled.draw_gaps": lambda: pooled.draw_gaps(presented()),
    "recording.draw_recording": lambda: recording.draw_recording(outcome().recording),
    "ding2021.convergence_figure": lambda: ding2021.convergence_figure(Histories()),
    "ding2021.tensor_figure": ding2021.tensor_figure,
    "li2017.parameter_figure": lambda: li2017.parameter_figure(simulated(0, 600)),
    "li2017.compensation_figure": lambda: li2017.compensation_figure(simulated(0, 600)),
    "li2017.adaptation_figure": li2017.adaptation_figure,
    "long2013.strength_figure": lambda: long2013.strength_figure(long_trial(LongTask(0, 100.0))),
    "long2013.attitude_figure": lambda: long2013.attitude_figure(long_trial(LongTask(0, 100.0))),
    "long2013.noise_figure": lambda: long2013.noise_figure({n: [long_trial(LongTask(0, n))] for n in (100.0, 200.0)}),
    "zhang2018.convergence_figure": lambda: zhang2018.convergence_figure(zhang_trials()),
    "zhang2018.turn_figure": lambda: zhang2018.turn_figure(zhang_trials()),
    "zhang2018.drift_figure": lambda: zhang2018.drift_figure([zhang_drift()]),
    "zhou2012.objective_figure": lambda: zhou2012.objective_figure([zhou_trial(ZhouTask(seed)) for seed in (0, 1)]),
    "zhou2012.course_figure": lambda: zhou2012.course_figure(stops()),
    "zhou2012.z_figure": lambda: zhou2012.z_figure(zhou_trial(ZhouTask(0))),
}
