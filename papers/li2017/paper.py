"""[Li2017]: 21 parameters with eddy currents by a Kalman filter, a rescaled one, and a fuzzy adaptive one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from calib.models.vector import VectorData
from papers.base import Findings, Progress, Reproduction, Work, run_tasks
from papers.li2017 import figures
from papers.li2017.fuzzy_rows import STATE_VARIANCES, adaptation, fuzzy_part
from papers.li2017.rows import ALL_MOTIONS, LONG, motions, original, proposed
from papers.li2017.survey_rows import levenberg_marquardt, quadrotor
from papers.li2017.trials import (
    SOURCES,
    changing_noise,
    long_run,
    marquardt,
    motion,
    sensitivity,
    simulated,
    survey,
    trial,
)
from reports.plots.style import Figure

SURVEYS = 5
"""Most seeds of the survey, whose simulation takes seconds."""
MARQUARDTS = 10


@dataclass(frozen=True)
class Li2017(Reproduction):
    """Table 1 and 2, figures 3 to 10 and 13 to 15."""

    key: ClassVar[str] = "Li2017"
    title: ClassVar[str] = "Component compensation: Kalman filter, rescaled and fuzzy adaptive, 21 parameters"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """The filters over the seeds, the longer runs over fewer, the quadrotor's survey."""
        seeds = range(self.seeds)
        few = seeds[:SURVEYS]
        work: Work = [
            (long_run, list(LONG)),
            (motion, list(ALL_MOTIONS)),
            (changing_noise, list(STATE_VARIANCES)),
            (sensitivity, [0]),
            (trial, list(seeds)),
            (survey, [(seed, ()) for seed in few]),
            (survey, [(seed, SOURCES) for seed in few]),
            (survey, [(0, (name,)) for name in SOURCES]),
            (marquardt, list(seeds[:MARQUARDTS])),
        ]
        long, turned, changing, table, trials, surveys, without, one_less, fitted = run_tasks(work, jobs, progress)
        rows = (
            *original(trials, long),
            *proposed(trials),
            motions(turned),
            *fuzzy_part(trials),
            *adaptation(trials, changing, table[0]),
            *quadrotor(surveys, without, one_less),
            *levenberg_marquardt(fitted),
        )
        return Findings(rows, _figures())


def _figures() -> dict[str, Callable[[], Figure]]:
    data: VectorData = simulated(0)
    return {
        "parameters": lambda: figures.parameters(data),
        "compensation": lambda: figures.compensation(data),
        "adaptation": figures.adaptation,
    }
