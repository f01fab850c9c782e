"""[Long2013]: maximum-likelihood ellipsoid by Newton's method; field strength, roll and pitch before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from papers.base import Findings, Progress, Reproduction, Work, run_tasks
from papers.long2013.figures import attitude_figure, noise_figure, strength_figure
from papers.long2013.flight_rows import VEHICLES, flight_rows, flight_trial
from papers.long2013.rows import NOISE_NT, NOISES_NT, rows
from papers.long2013.trials import LongTask, calibration_trial


@dataclass(frozen=True)
class Long2013(Reproduction):
    """Simulation with the printed errors, and rolling test on a simulated turntable."""

    key: ClassVar[str] = "Long2013"
    title: ClassVar[str] = "Ellipsoid calibration of a three-axis magnetometer by maximum likelihood"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """For each noise and seed, calibrate on four turns of 360 samples, then on flown motions, and roll once."""
        work: Work = [(calibration_trial, [LongTask(seed, noise) for seed in range(self.seeds)]) for noise in NOISES_NT]
        flights: Work = [(flight_trial, [(vehicle, self.seeds) for vehicle in VEHICLES])]
        *found, flown = run_tasks([*work, *flights], jobs, progress)
        by_noise = dict(zip(NOISES_NT, found, strict=True))
        first = by_noise[NOISE_NT][0]
        return Findings(
            (*rows(by_noise), *flight_rows(dict(zip(VEHICLES, flown, strict=True)))),
            {
                "strength": lambda: strength_figure(first),
                "attitude": lambda: attitude_figure(first),
                "noise": lambda: noise_figure(by_noise),
            },
        )
