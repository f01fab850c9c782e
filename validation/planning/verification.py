"""A planned motion flown many times: does a calibrator find what was predicted?"""

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
    """Rms error of the goal over so many trials by a calibrator, and how many of them it failed in."""

    calibrator: str
    error: float
    trials: int
    failures: int


def confirmed(scenario: Scenario, goal: Goal, trials: int, engine: Engine) -> Confirmed:
    """Fly the scenario with noise of its own each time; its one calibrator estimates.

    Raises InputError where the vehicle cannot do the motion.
    """
    (name,) = scenario.calibrators
    design = Design.of(scenario, select_calibrators([name]))
    column = SCORE_DEFINITIONS[goal.score].column
    rows = [row for trial in run_trials(design, range(trials), engine) for row in trial.rows if row.calibrator == name]
    errors = [row.scores[column] for row in rows if row.status == "ok" and column in row.scores]
    error = float(np.sqrt(np.mean(np.square(errors)))) if errors else np.inf
    return Confirmed(name, error, trials, trials - len(errors))
