"""Trials computed for gates until all are decided; the order of runs alone decides what is looked at."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np
import pyarrow as pa

from validation.comparison.design import received
from validation.comparison.engine import ENDED, Engine, Trials, computed
from validation.comparison.journal import Journal
from validation.comparison.trial import PendingTrial, Trial, TrialRow, failed_trial
from validation.gates.gate_groups import GateGroup, value_of
from validation.gates.gate_outcome import GateOutcome
from validation.gates.score_baseline import rows_of

Progress = Callable[[float, int], object]
"""Told (trials looked at, trials in all at most)."""
Rows = dict[str, TrialRow]
"""A trial's rows by calibrator."""


def decide_gates(
    groups: Sequence[GateGroup],
    engine: Engine,
    progress: Progress = lambda done, total: None,
    journal: Journal | None = None,
) -> list[GateOutcome]:
    """Run the trials of every group until its gates are decided or out of trials; outcomes in the order of groups.

    Each gate looks at the runs 0, 1, 2 ... of its group, whichever lands first, so that verdict and number of trials
    are the same for every engine, and after an interruption: what the journal has kept is not computed again.
    """
    total = sum(group.most for group in groups)
    with closing(_in_order(groups, engine, journal)) as trials:
        for group, run, rows in trials:
            for entry in group.entries:
                if not entry.progress.finished:
                    entry.progress.take(entry.reading(run, rows))
            progress(sum(group.looked for group in groups), total)
            if all(group.finished for group in groups):
                break
    progress(total, total)
    return [GateOutcome.of(entry.progress) for group in groups for entry in group.entries]


def record_scores(
    groups: Sequence[GateGroup], engine: Engine, progress: Progress = lambda done, total: None
) -> list[pa.Table]:
    """The score of every gate's calibrator in each of its max_trials trials, decided or not: rows of a baseline."""
    total = sum(group.most for group in groups)
    values = [[np.full(entry.progress.plan.max_trials, np.inf) for entry in group.entries] for group in groups]
    with closing(_in_order(groups, engine)) as trials:
        for done, (group, run, rows) in enumerate(trials, start=1):
            for entry, column in zip(group.entries, values[group.number], strict=True):
                if run < len(column):
                    column[run] = value_of(rows[entry.calibrator], entry.progress.plan.gate)
            progress(done, total)
    return [
        rows_of(group.design, entry.calibrator, entry.progress.plan.gate.score_definition.name, column)
        for group in groups
        for entry, column in zip(group.entries, values[group.number], strict=True)
    ]


@dataclass
class _Landing:
    """The trials of a group that came before their turn."""

    next: int = 0
    waiting: dict[int, Rows] = field(default_factory=dict)

    def ready(self, trial: Trial) -> Iterator[tuple[int, Rows]]:
        """The trials whose turn it is now that this one has landed."""
        self.waiting[trial.run] = {row.calibrator: row for row in trial.rows}
        while self.next in self.waiting:
            yield self.next, self.waiting.pop(self.next)
            self.next += 1


def _in_order(
    groups: Sequence[GateGroup], engine: Engine, journal: Journal | None = None
) -> Generator[tuple[GateGroup, int, Rows], None, None]:
    """Group, run and rows of every trial, those of a group in the order of runs."""
    landing = [_Landing() for _ in groups]
    with closing(_landed(groups, engine, journal)) as trials:
        for trial in trials:
            for run, rows in landing[trial.point].ready(trial):
                yield groups[trial.point], run, rows


def _landed(groups: Sequence[GateGroup], engine: Engine, journal: Journal | None) -> Trials:
    """Trials as they land: first those that are kept."""
    if journal is not None:
        yield from journal
    yield from computed(_tasks(groups), engine, _lost, journal)


def _tasks(groups: Sequence[GateGroup]) -> Iterator[PendingTrial]:
    """Asked for as workers come free, so that a group whose gates are decided takes no more."""
    for group in groups:
        for run in range(group.most):
            if group.finished:
                break
            yield PendingTrial(group.design.sent, group.number, run)


def _lost(task: PendingTrial) -> Trial:
    return failed_trial(received(task.sent), task.point, task.run, ENDED)
