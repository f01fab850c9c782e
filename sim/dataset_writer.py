"""Writer of datasets: many runs of a scenario as Parquet files with a manifest, in parallel, resumable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from recordings.columns import RUN, Column, schema
from recordings.files import locked_directory, remove_leftovers
from recordings.manifest import Manifest, folders, run_path
from recordings.metadata import RunFile, run_file
from recordings.resume import finish_dataset, open_dataset_for_writing
from recordings.split import Split, split_from
from recordings.writer import RunWriter
from scenarios.toml import as_dict
from sim.motion import Motion
from sim.pool import in_process, map_unordered
from sim.scenario import Scenario
from sim.simulation import Block, blocks, plan, true_motion
from sim.tracking import Tracker

Progress = Callable[[float, int], object]
"""Called with (runs done, runs in all); runs in this process count by the share done."""
Warn = Callable[[str], object]
"""Called with a warning, a single line."""


@dataclass(frozen=True)
class _Task:
    scenario: Scenario
    run: int
    seed: int
    out: Path
    split: Split | None


def generate(
    scenario: Scenario,
    out: Path,
    *,
    runs: int = 1,
    seed: int | None = None,
    jobs: int = 1,
    split: str | None = None,
    progress: Progress = lambda done, total: None,
    warn: Warn = lambda text: None,
) -> Manifest:
    """Write OUT/dataset.json and OUT/run-00000.parquet ...; complete runs listed in an existing manifest are kept.

    split : shares of training, validation and test, such as "80/10/10"; the runs are then in OUT/data/train/ ..., each
        row has a run number, and OUT holds the files of `recordings.description`.

    The bytes depend on the scenario, the seed and the run alone, never on `jobs`. Returns the manifest. Raises
    InputError for a bad scenario or split, for an OUT with a different dataset, for an OUT locked by a running process,
    and when the system refuses to write.
    """
    shares = None if split is None else split_from(split, scenario.seed if seed is None else seed)
    with locked_directory(out):
        return write_runs(scenario, out, runs, seed, jobs, progress, warn, shares)


def write_runs(
    scenario: Scenario,
    out: Path,
    runs: int,
    seed: int | None,
    jobs: int,
    progress: Progress,
    warn: Warn,
    split: Split | None = None,
) -> Manifest:
    """`generate` for a caller that already holds `locked_directory(out)`."""
    seed = scenario.seed if seed is None else seed
    columns = plan(scenario, 0, seed).columns
    todo = open_dataset_for_writing(out, as_dict(scenario), seed, runs, _table(columns, split), warn, split)
    files: list[RunFile] = []

    def advance(part: float = 0.0) -> None:
        progress(runs - len(todo) + len(files) + part, runs)

    advance()
    write = partial(_write, advance=advance) if in_process(todo, jobs) else _write
    tasks = [_Task(scenario, run, seed, out, split) for run in todo]
    try:
        with closing(map_unordered(write, tasks, jobs)) as done:
            for _, file in done:
                files.append(file)
                advance()
    except BaseException:  # an interruption too: the workers are gone, and what they had in hand
        for folder in folders(out):
            remove_leftovers(folder)
        raise
    return finish_dataset(out, files)


def _write(task: _Task, advance: Callable[[float], object] = lambda part: None) -> RunFile:
    ready = plan(task.scenario, task.run, task.seed)
    tracker = Tracker(ready.drawn.phases)

    def watched() -> Iterator[Motion]:
        for motion in true_motion(ready):
            tracker.see(motion)
            advance(_part(ready.drawn, motion))
            yield motion

    path = run_path(task.out, task.run, task.split)
    with RunWriter(path, schema(_table(ready.columns, task.split)), ready.metadata) as writer:
        for block in blocks(ready, watched()):
            writer.write(block if task.split is None else _numbered(block, task.run))
        writer.add_tracking(tracker.tracking)
    return run_file(path, task.run, task.out)


def _table(columns: tuple[Column, ...], split: Split | None) -> tuple[Column, ...]:
    """Columns of a file; in a split dataset, whose files are read together, each row has the number of the run."""
    return columns if split is None else (RUN, *columns)


def _numbered(block: Block, run: int) -> Block:
    return block | {RUN.name: np.full(len(block["time_s"]), run)}


def _part(scenario: Scenario, motion: Motion) -> float:
    """Share of the run's longest duration that has passed at the end of a block."""
    lengths_s = [phase.duration_s for phase in scenario.phases]
    return float((sum(lengths_s[: motion.phase]) + motion.phase_time_s[-1]) / sum(lengths_s))
