"""Writes datasets: many runs of a scenario as Parquet files with a manifest, in parallel, resumable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from scenarios.toml import as_dict
from sim.dataset.columns import schema
from sim.dataset.files import locked_directory, remove_leftovers
from sim.dataset.manifest import Manifest, run_path
from sim.dataset.metadata import RunFile, run_file
from sim.dataset.resume import finish_dataset, open_dataset_for_writing
from sim.dataset.writer import RunWriter
from sim.motion import Motion
from sim.pool import in_process, map_unordered
from sim.scenario import Scenario
from sim.simulate import blocks, flown, plan
from sim.tracking import Tracker

Progress = Callable[[float, int], object]
"""Called with (runs done, runs in all); of a run that this process makes itself its part that is done counts too."""
Warn = Callable[[str], object]
"""Called with a line about what is amiss though the work goes on."""


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
    warn: Warn = lambda text: None,
) -> Manifest:
    """Write OUT/dataset.json and OUT/run-00000.parquet ...; runs that are whole and as listed already are kept.

    The bytes depend on the scenario, the seed and the run alone, never on `jobs`. Returns the manifest. Raises
    InputError for a bad scenario, for an OUT that holds another dataset or that another process writes to, and when
    the system refuses to write.
    """
    with locked_directory(out):
        return write_runs(scenario, out, runs, seed, jobs, progress, warn)


def write_runs(
    scenario: Scenario, out: Path, runs: int, seed: int | None, jobs: int, progress: Progress, warn: Warn
) -> Manifest:
    """`generate` for a caller that holds `locked_directory(out)` already."""
    seed = scenario.seed if seed is None else seed
    columns = plan(scenario, 0, seed).columns
    todo = open_dataset_for_writing(out, as_dict(scenario), seed, runs, columns, warn)
    files: list[RunFile] = []

    def advance(part: float = 0.0) -> None:
        progress(runs - len(todo) + len(files) + part, runs)

    advance()
    write = partial(_write, advance=advance) if in_process(todo, jobs) else _write
    tasks = [_Task(scenario, run, seed, run_path(out, run)) for run in todo]
    try:
        with closing(map_unordered(write, tasks, jobs)) as done:
            for _, file in done:
                files.append(file)
                advance()
    except BaseException:  # an interruption too: the workers are gone, and what they had in hand
        remove_leftovers(out)
        raise
    return finish_dataset(out, files)


def _write(task: _Task, advance: Callable[[float], object] = lambda part: None) -> RunFile:
    ready = plan(task.scenario, task.run, task.seed)
    tracker = Tracker(ready.drawn.phases)

    def watched() -> Iterator[Motion]:
        for motion in flown(ready):
            tracker.see(motion)
            advance(_part(ready.drawn, motion))
            yield motion

    with RunWriter(task.path, schema(ready.columns), ready.metadata) as writer:
        for block in blocks(ready, watched()):
            writer.write(block)
        writer.add_tracking(tracker.tracking)
    return run_file(task.path, task.run)


def _part(scenario: Scenario, motion: Motion) -> float:
    """How much of the run is done after this block; a dive that ends before its longest duration jumps ahead."""
    lengths_s = [phase.duration_s for phase in scenario.phases]
    return float((sum(lengths_s[: motion.phase]) + motion.phase_time_s[-1]) / sum(lengths_s))
