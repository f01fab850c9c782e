"""[Zhang2018]: an AUV's spiral; ellipsoid fit, particle swarm, genetic algorithm and their hybrid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from papers.base import Findings, Progress, Reproduction, run_tasks
from papers.zhang2018.ellipsoid_rows import drifting, level
from papers.zhang2018.figures import convergence_figure, drift_figure, turn_figure
from papers.zhang2018.printed_table import reductions, signs
from papers.zhang2018.rows import accuracy, convergence, errors
from papers.zhang2018.trials import drift_trial, search_trial


@dataclass(frozen=True)
class Zhang2018(Reproduction):
    """The spiral of the paper with the errors of the scenario `auv-dive`, calibrated by the paper's methods."""

    key: ClassVar[str] = "Zhang2018"
    title: ClassVar[str] = "In-situ calibration of a vector magnetometer on an AUV: ellipsoid, PSO, GA, PSOGA"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """The level spiral under every setting, then the excited spiral under every drift."""
        seeds = range(self.seeds)
        trials, drifts = run_tasks([(search_trial, seeds), (drift_trial, seeds)], jobs, progress)
        rows = (
            *errors(trials),
            reductions(),
            signs(),
            *convergence(trials),
            accuracy(trials),
            level(),
            *drifting(drifts),
        )
        return Findings(
            rows,
            {
                "convergence": lambda: convergence_figure(trials),
                "turn": lambda: turn_figure(trials),
                "drift": lambda: drift_figure(drifts),
            },
        )
