"""One trial: a run simulated in memory, every candidate fitted to it and scored; the same wherever it is computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Calibration, Reference
from calib.numerics.threads import one_thread
from scenarios.seeds import stream
from sim.memory_run import run_in_memory
from sim.motion_cache import MotionCache
from sim.simulation import plan
from validation.comparison.design import Design, received
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.evaluation import ScoredCalibration, has_estimate, score_calibrators

NOT_KEPT = ("failure", "wall_time")
"""Scores that a row has no column for: its status says the one, and the other is never the same twice."""
CALIBRATORS_STREAM = "calibrator"
"""Name of the random stream that every fit of a trial begins with."""
FLIGHTS = MotionCache()
"""The motions of this process."""


@dataclass(frozen=True)
class TrialRow:
    """One calibrator in one trial.

    scores: by column (`validation.scoring.definitions`), finite; empty where the calibrator gave no estimate.
    wall_s, cpu_s: elapsed and processor time of the fit, which alone differ from one computation to the next.
    """

    calibrator: str
    status: str
    reason: str
    scores: dict[str, float]
    wall_s: float
    cpu_s: float


@dataclass(frozen=True)
class Trial:
    """What trial (point, run) gave: a row a calibrator, in the order of `Design.calibrators`."""

    point: int
    run: int
    rows: tuple[TrialRow, ...]


@dataclass(frozen=True)
class PendingTrial:
    """A trial that is still to be computed, as it goes to a worker."""

    sent: bytes
    point: int
    run: int


def compute(task: PendingTrial) -> Trial:
    """In a worker: the trial of a task."""
    return run_trial(received(task.sent), task.point, task.run)


def run_trial(design: Design, point: int, run: int) -> Trial:
    """Simulate the run, fit every candidate with one thread, score; a pure function but for the times.

    Raises InputError where the vehicle cannot do the motion, or a draw leaves its range.
    """
    with one_thread():
        ready = plan(design.points[point].scenario, run, design.seed)
        recording, _ = run_in_memory(ready, FLIGHTS.motions(ready))
        east, north, up = ready.field_enu_nT.tolist()
        reference = Reference(float(np.linalg.norm(ready.field_enu_nT)), (east, north, up))
        found = score_calibrators(
            recording,
            ready.effects,
            reference,
            design.candidates,
            lambda: stream(design.seed, run, CALIBRATORS_STREAM),
        )
    return Trial(point, run, tuple(_row(found[name]) for name in design.calibrators))


def failed_trial(design: Design, point: int, run: int, reason: str) -> Trial:
    """The trial of a worker that did not live to tell: every candidate failed, for this reason."""
    rows = (TrialRow(name, "not_converged", reason, {}, 0.0, 0.0) for name in design.calibrators)
    return Trial(point, run, tuple(rows))


def _row(one: ScoredCalibration) -> TrialRow:
    calibration: Calibration = one.fit.calibration
    scores = {
        SCORE_DEFINITIONS[score.name].column: float(score.value) for score in one.scores if score.name not in NOT_KEPT
    }
    finite = {name: value for name, value in scores.items() if np.isfinite(value)}
    kept = finite if has_estimate(calibration) else {}
    status = calibration.status
    return TrialRow(one.fit.key, status.kind, status.reason, kept, calibration.wall_s, one.fit.cpu_s)
