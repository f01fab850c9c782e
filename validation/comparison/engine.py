"""Engines that compute trials, serially or in processes; results do not depend on the engine."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from scenarios.errors import InputError
from sim.pool import map_unordered
from validation.comparison.design import Design
from validation.comparison.journal import Journal
from validation.comparison.trial import PendingTrial, Trial, compute, failed_trial
from validation.text import counted

ENDED = "every process that computed this trial was ended: a calibrator crashes, or memory does not suffice"


Trials: TypeAlias = Generator[Trial, None, None]
"""Trials in order of completion; closing the generator ends the workers."""


class GoneError(InputError):
    """The engine is lost; completed trials are kept."""


class Engine(Protocol):
    """Computes tasks in any order; tasks of a dead worker are repeated."""

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """Yield the trial of every task in order of completion; tasks are taken a bounded number ahead.

        on_loss : makes the trial of a task that ended its worker repeatedly.
        """


@dataclass(frozen=True)
class SerialEngine:
    """Engine without workers, for a few small trials; a crashing calibrator ends the calling process."""

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """Compute the trials one by one."""
        yield from map(compute, tasks)


@dataclass(frozen=True)
class ProcessEngine:
    """Engine of `jobs` processes on the local machine."""

    jobs: int

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """Compute the trials by `sim.pool.map_unordered`."""
        with closing(map_unordered(compute, tasks, self.jobs, on_loss)) as found:
            yield from (trial for _, trial in found)


def run_trials(design: Design, runs: Sequence[int], engine: Engine, journal: Journal | None = None) -> Trials:
    """Yield the trials of `runs` at every point: first the kept trials, then computed trials in order of completion.

    journal : see `computed`. All points of a run are scheduled before the next run, so a comparison stopped early is
    nearly balanced. Raises InputError where a run cannot be simulated, and where the engine is lost.
    """
    wanted = set(runs)
    if journal is not None:
        yield from (trial for trial in journal if trial.run in wanted)
    yield from new_trials(design, runs, engine, journal)


def new_trials(design: Design, runs: Sequence[int], engine: Engine, journal: Journal | None = None) -> Trials:
    """Yield the trials of `runs` at every point that are not in the journal; see `run_trials`."""
    points = range(len(design.points))
    tasks = (PendingTrial(design.sent, point, run) for run in runs for point in points)
    yield from computed(tasks, engine, lambda task: failed_trial(design, task.point, task.run, ENDED), journal)


def computed(
    tasks: Iterable[PendingTrial],
    engine: Engine,
    on_loss: Callable[[PendingTrial], Trial],
    journal: Journal | None = None,
) -> Trials:
    """Yield the trials of tasks in order of completion; trials in the journal are skipped, new trials are added."""
    there = set() if journal is None else set(journal.there)
    todo = (task for task in tasks if (task.point, task.run) not in there)
    try:
        with closing(engine.trials(todo, on_loss)) as found:
            for trial in found:
                if journal is not None:
                    journal.add(trial)
                yield trial
    except GoneError as error:
        kept = "no trial is kept" if journal is None else f"{counted(len(journal.there), 'trial')} kept"
        raise InputError(f"{error.what}; {kept}", where=error.where, do=error.do) from None
