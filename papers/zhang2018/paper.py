"""[Zhang2018]: spiral of an AUV; ellipsoid fit, particle swarm, genetic algorithm and hybrid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from papers.base import Findings, Progress, Reproduction, Work, run_tasks
from papers.zhang2018.axis_fit import axis_rows, axis_trial
from papers.zhang2018.ellipsoid_rows import drift_rows, level_spiral_row, quadric_row
from papers.zhang2018.figures import convergence_figure, drift_figure, turn_figure
from papers.zhang2018.least_squares import least_squares_row, least_squares_trial
from papers.zhang2018.relative_error import relative_error_rows
from papers.zhang2018.rows import accuracy_row, convergence_rows, error_rows, table_rows
from papers.zhang2018.trials import drift_trial, quadric_trial, search_trial


@dataclass(frozen=True)
class Zhang2018(Reproduction):
    """The paper's spiral with the errors of the scenario `auv-dive`, calibrated by the paper's methods."""

    key: ClassVar[str] = "Zhang2018"
    title: ClassVar[str] = "In-situ calibration of a vector magnetometer on an AUV: ellipsoid, PSO, GA, PSOGA"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Search on the level spiral under every setting, then fit the excited spiral under every drift."""
        seeds = range(self.seeds)
        each = (search_trial, drift_trial, quadric_trial, least_squares_trial, axis_trial)
        work: Work = [(trial, seeds) for trial in each]
        trials, drifts, quadrics, fits, axes = run_tasks(work, jobs, progress)
        rows = (
            *error_rows(trials),
            *table_rows(),
            *convergence_rows(trials),
            *relative_error_rows(trials),
            accuracy_row(trials),
            level_spiral_row(),
            quadric_row(quadrics),
            least_squares_row(fits),
            *axis_rows(axes),
            *drift_rows(drifts),
        )
        return Findings(
            rows,
            {
                "convergence": lambda: convergence_figure(trials),
                "turn": lambda: turn_figure(trials),
                "drift": lambda: drift_figure(drifts),
            },
        )
