"""A trial: a run simulated in memory, fitted by every calibrator and scored; a pure function of design and run."""

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
from validation.scoring.evaluation import ScoredCalibration, score_calibrators

NOT_KEPT = ("failure", "wall_time")
"""Scores without a column: the status holds the first, and the second is not reproducible."""
CALIBRATORS_STREAM = "calibrator"
"""Name of the random stream of every fit in a trial."""
FLIGHTS = MotionCache()
"""Cache of simulated motions in the process."""


@dataclass(frozen=True)
class TrialRow:
    """Result of a calibrator in a trial.

    scores : finite values by column (`validation.scoring.definitions`); empty without an estimate.
    wall_s, cpu_s : elapsed and processor time of the fit, the only values that are not reproducible.
    """

    calibrator: str
    status: str
    reason: str
    scores: dict[str, float]
    wall_s: float
    cpu_s: float


@dataclass(frozen=True)
class Trial:
    """Result of trial (point, run): a row for each calibrator, in the order of `Design.calibrators`."""

    point: int
    run: int
    rows: tuple[TrialRow, ...]


@dataclass(frozen=True)
class PendingTrial:
    """A trial to be computed, in the form sent to a worker."""

    sent: bytes
    point: int
    run: int


def compute(task: PendingTrial) -> Trial:
    """Compute the trial of a task, in a worker."""
    return run_trial(received(task.sent), task.point, task.run)


def run_trial(design: Design, point: int, run: int) -> Trial:
    """Simulate a run, fit every calibrator with one thread, and score; all but the times is reproducible.

    Raises InputError where the vehicle cannot follow the motion, or a random parameter leaves the allowed range.
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
    """Return the trial of a lost worker: every calibrator failed for a reason."""
    rows = (TrialRow(name, "not_converged", reason, {}, 0.0, 0.0) for name in design.calibrators)
    return Trial(point, run, tuple(rows))


def _row(one: ScoredCalibration) -> TrialRow:
    calibration: Calibration = one.fit.calibration
    scores = {
        SCORE_DEFINITIONS[score.name].column: float(score.value) for score in one.scores if score.name not in NOT_KEPT
    }
    finite = {name: value for name, value in scores.items() if np.isfinite(value)}
    kept = finite if calibration.has_estimate else {}
    status = calibration.status
    reason = status.reason.encode(errors="replace").decode()  # a program may give half of a surrogate pair
    return TrialRow(one.fit.key, status.kind, reason, kept, calibration.wall_s, one.fit.cpu_s)
