"""[Ding2021]: gradiometer of four sensors, 48 parameters, calibrated by improved differential evolution."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from papers.base import Findings, PaperRow, Progress, Reproduction, Work, run_tasks
from papers.ding2021.figures import convergence_figure, tensor_figure
from papers.ding2021.geometry_rows import geometry_rows, geometry_trial
from papers.ding2021.rotations import rotation_rows, rotation_trial
from papers.ding2021.rows import NOISES_NT, simulation_rows
from papers.ding2021.search_rows import search_rows
from papers.ding2021.search_trials import StartTask, search_trial, searches, start_trial
from papers.ding2021.trials import SpreadTask, spread_trial
from papers.judgement import incomparable

FEW, EVOLVED = 5, 3
"""Seeds of the longer searches: populations, counts of attitudes; and for each pair F, CR and each comparison."""
REAL_ARRAY = PaperRow(
    "real array, 60 samples: total rms after (evolution, genetic, least squares)",
    "3.398, 18.197, 14.210 nT",
    "no data",
    incomparable("the measurements are not published"),
    "the paper's measurements are not published",
)


@dataclass(frozen=True)
class Ding2021(Reproduction):
    """Both simulations: 200 random attitudes, noise uniform within 0, 2, 5, 10 nT.

    Spreads are computed by least squares from the two-step start (Levenberg-Marquardt), shown in a row to end in the
    same minimum as the evolution.
    """

    key: ClassVar[str] = "Ding2021"
    title: ClassVar[str] = "Gradiometer of four sensors by improved differential evolution"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Repeat the simulations over all seeds, and the searches over fewer seeds."""
        few, evolved = min(FEW, self.seeds), min(EVOLVED, self.seeds)
        keyed: Work = [
            (search_trial, list(searches(few, evolved))),
            (spread_trial, list(_spreads(self.seeds, evolved))),
            (start_trial, [StartTask(seed) for seed in range(self.seeds)]),
        ]
        other: Work = [(trial, range(self.seeds)) for trial in (geometry_trial, rotation_trial)]
        *found, shaped, turned = run_tasks([*keyed, *other], jobs, progress)
        tasks = itertools.chain.from_iterable(items for _, items in keyed)
        results = dict(zip(tasks, itertools.chain.from_iterable(found), strict=True))
        rows = (
            *simulation_rows(results, self.seeds, evolved),
            *search_rows(results, self.seeds, few, evolved),
            *geometry_rows(shaped),
            *rotation_rows(turned),
            REAL_ARRAY,
        )
        return Findings(rows, {"convergence": lambda: convergence_figure(results), "tensor": tensor_figure})


def _spreads(seeds: int, evolved: int) -> Iterable[SpreadTask]:
    """Yield each simulation, noise and seed; at the largest noise also with equal noise on all four sensors."""
    for case, noise, seed in itertools.product((1, 2), (0.0, *NOISES_NT), range(seeds)):
        yield SpreadTask(case, noise, seed, evolve=noise in (0.0, 10.0) and seed < evolved)
        if noise == NOISES_NT[-1]:
            yield SpreadTask(case, noise, seed, common=True)
