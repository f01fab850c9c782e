"""Runs trials until all gates are decided; trials are tested in the order of runs, whatever the engine."""

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
from validation.gates.gate_groups import GateGroup, gate_score
from validation.gates.gate_outcome import GateOutcome
from validation.gates.score_baseline import rows_of

Progress = Callable[[float, int], object]
"""Called with (trials done, largest number of trials)."""
Rows = dict[str, TrialRow]
"""Rows of a trial by calibrator."""


def decide_gates(
    groups: Sequence[GateGroup],
    engine: Engine,
    progress: Progress = lambda done, total: None,
    journal: Journal | None = None,
) -> list[GateOutcome]:
    """Run the trials of every group until the gates are decided or out of trials; return outcomes in group order.

    Each gate tests runs 0, 1, 2 ... in order, so verdict and number of trials do not depend on the engine or on an
    interruption; trials in the journal are not computed again.
    """
    total = sum(group.max_trials for group in groups)
    with closing(_in_order(groups, engine, journal)) as trials:
        for group, run, rows in trials:
            for entry in group.entries:
                if not entry.progress.finished:
                    entry.progress.add(entry.read_trial(run, rows))
            progress(sum(group.trials_done for group in groups), total)
            if all(group.finished for group in groups):
                break
    progress(total, total)
    return [GateOutcome.of(entry.progress) for group in groups for entry in group.entries]


def record_scores(
    groups: Sequence[GateGroup], engine: Engine, progress: Progress = lambda done, total: None
) -> list[pa.Table]:
    """Return baseline rows: the score of every gate's calibrator in all max_trials trials, decided or not."""
    total = sum(group.max_trials for group in groups)
    values = [[np.full(entry.progress.plan.max_trials, np.inf) for entry in group.entries] for group in groups]
    with closing(_in_order(groups, engine)) as trials:
        for done, (group, run, rows) in enumerate(trials, start=1):
            for entry, column in zip(group.entries, values[group.number], strict=True):
                if run < len(column):
                    column[run] = gate_score(rows[entry.calibrator], entry.progress.plan.gate)
            progress(done, total)
    return [
        rows_of(group.design, entry.calibrator, entry.progress.plan.gate.score_definition.name, column)
        for group in groups
        for entry, column in zip(group.entries, values[group.number], strict=True)
    ]


@dataclass
class _Reordering:
    """Trials of a group that arrived out of order."""

    next: int = 0
    waiting: dict[int, Rows] = field(default_factory=dict)

    def ready(self, trial: Trial) -> Iterator[tuple[int, Rows]]:
        """Add a trial and yield the trials now in order."""
        self.waiting[trial.run] = {row.calibrator: row for row in trial.rows}
        while self.next in self.waiting:
            yield self.next, self.waiting.pop(self.next)
            self.next += 1


def _in_order(
    groups: Sequence[GateGroup], engine: Engine, journal: Journal | None = None
) -> Generator[tuple[GateGroup, int, Rows], None, None]:
    """Yield group, run and rows of every trial, within a group in the order of runs."""
    waiting = [_Reordering() for _ in groups]
    with closing(_completed(groups, engine, journal)) as trials:
        for trial in trials:
            for run, rows in waiting[trial.point].ready(trial):
                yield groups[trial.point], run, rows


def _completed(groups: Sequence[GateGroup], engine: Engine, journal: Journal | None) -> Trials:
    """Yield trials in order of completion, kept trials first."""
    if journal is not None:
        yield from journal
    yield from computed(_tasks(groups), engine, _lost, journal)


def _tasks(groups: Sequence[GateGroup]) -> Iterator[PendingTrial]:
    """Yield tasks lazily, so a group with decided gates takes no further tasks."""
    for group in groups:
        for run in range(group.max_trials):
            if group.finished:
                break
            yield PendingTrial(group.design.sent, group.number, run)


def _lost(task: PendingTrial) -> Trial:
    return failed_trial(received(task.sent), task.point, task.run, ENDED)
