"""[Li2017]: 21 parameters with eddy currents by a Kalman filter, with rescaled and fuzzy adaptive variants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from calib.models.vector import VectorData
from papers.base import Findings, Progress, Reproduction, Work, run_tasks
from papers.li2017 import figures
from papers.li2017.flight_rows import VEHICLES, FlightTask, flight_rows, flight_trial
from papers.li2017.fuzzy_rows import STATE_VARIANCES, adaptation_rows, exponent_row, fuzzy_rows
from papers.li2017.rival_rows import rival_rows, rival_trial
from papers.li2017.rows import ALL_MOTIONS, LONG, engine_row, motion_row, original_filter_rows, proposed_filter_rows
from papers.li2017.survey_rows import levenberg_marquardt_rows, quadrotor_rows
from papers.li2017.trials import (
    ENGINE_FILTERS,
    EXPONENTS,
    SOURCES,
    changing_noise_trial,
    engine_trial,
    exponent_trial,
    filter_trial,
    long_trial,
    marquardt_trial,
    motion_trial,
    sensitivity_trial,
    simulated,
    survey_trial,
)
from reports.plots.style import Figure

SURVEYS = 5
"""Most seeds of the survey, whose simulation takes seconds."""
MARQUARDTS, FLIGHTS = 10, 10


@dataclass(frozen=True)
class Li2017(Reproduction):
    """Tables 1 and 2, figures 3 to 10 and 13 to 15."""

    key: ClassVar[str] = "Li2017"
    title: ClassVar[str] = "Component compensation: Kalman filter, rescaled and fuzzy adaptive, 21 parameters"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Run the filters over all seeds, the longer runs over fewer, and the quadrotor's survey."""
        found = run_tasks(self._work(), jobs, progress)
        (
            long,
            turned,
            changing,
            table,
            trials,
            surveys,
            without,
            one_less,
            fitted,
            engines,
            changes,
            rivals,
            *flights,
        ) = found
        rows = (
            *original_filter_rows(trials, long),
            *proposed_filter_rows(trials),
            motion_row(turned),
            engine_row(engines),
            *fuzzy_rows(trials),
            *adaptation_rows(trials, changing, table[0]),
            exponent_row(changes),
            *quadrotor_rows(surveys, without, one_less),
            *levenberg_marquardt_rows(fitted),
            *rival_rows(rivals, trials, surveys),
            *flight_rows(dict(zip(VEHICLES, flights, strict=True))),
        )
        return Findings(rows, _figures())

    def _work(self) -> Work:
        seeds = range(self.seeds)
        few = seeds[:SURVEYS]
        return [
            (long_trial, list(LONG)),
            (motion_trial, list(ALL_MOTIONS)),
            (changing_noise_trial, list(STATE_VARIANCES)),
            (sensitivity_trial, [0]),
            (filter_trial, list(seeds)),
            (survey_trial, [(seed, ()) for seed in few]),
            (survey_trial, [(seed, SOURCES) for seed in few]),
            (survey_trial, [(0, (name,)) for name in SOURCES]),
            (marquardt_trial, list(seeds[:MARQUARDTS])),
            (engine_trial, list(ENGINE_FILTERS)),
            (exponent_trial, list(EXPONENTS)),
            (rival_trial, list(seeds)),
            *((flight_trial, [FlightTask(vehicle, seed) for seed in seeds[:FLIGHTS]]) for vehicle in VEHICLES),
        ]


def _figures() -> dict[str, Callable[[], Figure]]:
    data: VectorData = simulated(0)
    return {
        "parameters": lambda: figures.parameter_figure(data),
        "compensation": lambda: figures.compensation_figure(data),
        "adaptation": figures.adaptation_figure,
    }
