"""Who computes trials: this process, or processes of this machine. No engine changes a figure."""

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
"""Trials as they land; closing it ends the workers."""


class GoneError(InputError):
    """What computes trials is gone; those that have landed are kept."""


class Engine(Protocol):
    """Computes tasks in any order; a worker that dies costs a repeat."""

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """The trial of every task, as they land; tasks are taken as they are needed, a bounded number ahead.

        lost : what is told of a task that ended its worker again and again.
        """


@dataclass(frozen=True)
class SerialEngine:
    """This process: for a few small trials. A calibrator that crashes takes it down."""

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """One after the other."""
        yield from map(compute, tasks)


@dataclass(frozen=True)
class ProcessEngine:
    """So many processes of this machine."""

    jobs: int

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """As `sim.pool.map_unordered`."""
        with closing(map_unordered(compute, tasks, self.jobs, on_loss)) as found:
            yield from (trial for _, trial in found)


def run_trials(design: Design, runs: Sequence[int], engine: Engine, journal: Journal | None = None) -> Trials:
    """The trials of these runs at every point as they land, in any order: first the kept ones, then what is computed.

    journal : as in `computed`. All points of a run come before the next run, so that a comparison that is stopped
    early is nearly balanced. Raises InputError where a run cannot be simulated, and where the engine is gone.
    """
    wanted, points = set(runs), range(len(design.points))
    if journal is not None:
        yield from (trial for trial in journal if trial.run in wanted)
    tasks = (PendingTrial(design.sent, point, run) for run in runs for point in points)
    yield from computed(tasks, engine, lambda task: failed_trial(design, task.point, task.run, ENDED), journal)


def computed(
    tasks: Iterable[PendingTrial],
    engine: Engine,
    on_loss: Callable[[PendingTrial], Trial],
    journal: Journal | None = None,
) -> Trials:
    """The trials of tasks as they land, but for those that the journal has kept already; all others it keeps."""
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
