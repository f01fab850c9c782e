"""What a comparison costs beside its trials: the engine's own work, and the physics that trials share."""

from __future__ import annotations

import tempfile
from pathlib import Path

from benchmarks.measure import Row, cpu_s
from sim.scenario import Scenario, load
from sim.simulate import flown, plan
from validation.calibrating.candidates import candidates
from validation.comparison.design import Design
from validation.comparison.engine import Processes, run_trials
from validation.comparison.journal import Journal
from validation.comparison.trial import run_trial

MOST_ENGINE, MOST_PHYSICS = 0.03, 0.10
TRIALS, PROCESSES = 200, 2
"""The comparison that both shares are of."""
TWELVE = (
    *("sphere", "ellipsoid", "vector_least_squares", "ellipsoid_segmented", "twostep", "ml_newton"),
    *("pso", "ga", "psoga", "kalman", "ukf", "vector_lm"),
)


def spiral() -> Scenario:
    """Twenty minutes of an AUV's circles at 10 Hz."""
    return load("auv-spiral", ["phases.0.duration_s=1200"])


def rows() -> list[Row]:
    """A row for the engine, and one for the physics."""
    return [_engine(), _physics()]


def _engine(trials: int = 60) -> Row:
    """The submitting process' own work against that of trials with three methods that take milliseconds."""
    design = Design.of(spiral(), candidates(["sphere", "ellipsoid", "vector_least_squares"]), seed=1)
    run_trial(design, 0, 0)
    trial_s = min(cpu_s(lambda run=run: run_trial(design, 0, run)) for run in (1, 2, 3))  # type: ignore[misc]
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal.open(Path(folder), design.identity())
        found = run_trials(design, range(trials), Processes(PROCESSES), journal)
        next(found)  # the pool stands
        own_s = cpu_s(lambda: list(found)) / (trials - 1)
    note = f"{1e3 * own_s:.2f} ms a trial, trials of {1e3 * trial_s:.0f} ms"
    return Row("comparison: engine / trials", own_s / trial_s, MOST_ENGINE, False, note)


def _physics() -> Row:
    design = Design.of(spiral(), candidates(TWELVE), seed=1)
    flown_s = cpu_s(lambda: list(flown(plan(design.points[0].scenario, 0, 1))))
    run_trial(design, 0, 0)
    trial_s = cpu_s(lambda: run_trial(design, 0, 1))
    share = PROCESSES * flown_s / (TRIALS * trial_s)
    note = f"{TRIALS} trials, {PROCESSES} processes: motion {flown_s:.2f} s once in each, trial {trial_s:.2f} s"
    return Row("comparison: physics / trials", share, MOST_PHYSICS, False, note)
