"""[Zhou2012]: five direction cosines from twelve stops about the vertical, by differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from papers.base import Findings, Progress, Reproduction, Work, run_tasks
from papers.zhou2012.figures import course_figure, objective_figure, z_figure
from papers.zhou2012.flight_rows import VEHICLES, flight_rows, flight_trial
from papers.zhou2012.rows import rows
from papers.zhou2012.trials import OFFSET_NT, ZhouTask, search_trial, stops


@dataclass(frozen=True)
class Zhou2012(Reproduction):
    """The paper's five values as the truth of a simulated turntable run, estimated by the paper's algorithm."""

    key: ClassVar[str] = "Zhou2012"
    title: ClassVar[str] = "Joint correction of non-orthogonality and non-levelness by differential evolution"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Simulate twelve stops per seed with fresh noise, without and with an offset, and twelve stops flown."""
        seeds = range(self.seeds)
        held: Work = [(search_trial, [ZhouTask(seed, offset) for seed in seeds]) for offset in (0.0, OFFSET_NT)]
        flights: Work = [(flight_trial, [(vehicle, seed) for seed in seeds]) for vehicle in VEHICLES]
        clean, shifted, *flown = run_tasks([*held, *flights], jobs, progress)
        state = stops()
        return Findings(
            (*rows(clean, shifted, state), *flight_rows(dict(zip(VEHICLES, flown, strict=True)))),
            {
                "objective": lambda: objective_figure(clean),
                "parameters": lambda: course_figure(state),
                "z": lambda: z_figure(clean[0]),
            },
        )
