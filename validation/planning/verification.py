"""Verification of a plan: a calibrator's error over many simulated flights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.scenario import Scenario
from validation.bound.goal import Goal
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.engine import Engine, run_trials
from validation.scoring.definitions import SCORE_DEFINITIONS


@dataclass(frozen=True)
class Confirmed:
    """Rms error of the goal over trials of a calibrator, and the number of failures."""

    calibrator: str
    error: float
    trials: int
    failures: int


def confirmed(scenario: Scenario, goal: Goal, trials: int, engine: Engine) -> Confirmed:
    """Simulate the scenario with new noise for each trial, and run the scenario's calibrator.

    Raises InputError if the vehicle cannot perform the motion.
    """
    (name,) = scenario.calibrators
    design = Design.of(scenario, select_calibrators([name]))
    column = SCORE_DEFINITIONS[goal.score].column
    rows = [row for trial in run_trials(design, range(trials), engine) for row in trial.rows if row.calibrator == name]
    errors = [row.scores[column] for row in rows if row.status == "ok" and column in row.scores]
    error = float(np.sqrt(np.mean(np.square(errors)))) if errors else np.inf
    return Confirmed(name, error, trials, trials - len(errors))
