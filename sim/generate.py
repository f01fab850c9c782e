"""Writes datasets: many runs of a scenario as Parquet files with a manifest, in parallel, resumable."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from scenarios.load import as_dict
from scenarios.spec import Scenario
from sim.dataset.columns import schema
from sim.dataset.files import alone_in, remove_leftovers
from sim.dataset.manifest import Manifest, finish_dataset, open_dataset_for_writing, run_path
from sim.dataset.writer import RunFile, RunWriter, run_file
from sim.pool import each
from sim.simulate import blocks, plan
from sim.tracking import Tracker

Progress = Callable[[int, int], object]
"""Called with (runs done, runs in all)."""


@dataclass(frozen=True)
class _Task:
    scenario: Scenario
    run: int
    seed: int
    path: Path


def generate(
    scenario: Scenario,
    out: Path,
    *,
    runs: int = 1,
    seed: int | None = None,
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
) -> Manifest:
    """Write OUT/dataset.json and OUT/run-00000.parquet ...; runs that are whole already are kept.

    The bytes depend on the scenario, the seed and the run alone, never on `jobs`. Raises InputError for a bad
    scenario, for an OUT that holds another dataset or that another process writes to, and when the system refuses to
    write.
    """
    with alone_in(out):
        return write_runs(scenario, out, runs=runs, seed=seed, jobs=jobs, progress=progress)


def write_runs(
    scenario: Scenario,
    out: Path,
    *,
    runs: int = 1,
    seed: int | None = None,
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
) -> Manifest:
    """`generate` for a caller that is `alone_in(out)` already."""
    seed = scenario.seed if seed is None else seed
    todo = open_dataset_for_writing(out, as_dict(scenario), seed, runs, plan(scenario, 0, seed).columns)
    progress(runs - len(todo), runs)
    files = []
    tasks = [_Task(scenario, run, seed, run_path(out, run)) for run in todo]
    try:
        with closing(each(_write, tasks, jobs)) as done:
            for _, file in done:
                files.append(file)
                progress(runs - len(todo) + len(files), runs)
    except BaseException:  # an interruption too: the workers are gone, and what they had in hand
        remove_leftovers(out)
        raise
    return finish_dataset(out, files)


def _write(task: _Task) -> RunFile:
    ready = plan(task.scenario, task.run, task.seed)
    tracker = Tracker(ready.drawn.phases)
    with RunWriter(task.path, schema(ready.columns), ready.metadata) as writer:
        for block in blocks(ready, tracker.see):
            writer.write(block)
        writer.add_tracking(tracker.tracking)
    return run_file(task.path, task.run)
