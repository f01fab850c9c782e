"""Writer of datasets: many runs of a scenario as Parquet files with a manifest, in parallel, resumable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial

from recordings.columns import RUN, Column
from recordings.files import locked_directory, remove_leftovers
from recordings.layout import DatasetLayout
from recordings.manifest import Manifest, folders
from recordings.metadata import RunFile
from recordings.resume import Checked, FileCheck, check_file, finish_dataset, open_dataset_for_writing
from recordings.split import split_from
from recordings.url_path import Place
from scenarios.errors import InputError
from scenarios.toml import as_dict
from sim.file_writer import FileTask, write_file
from sim.motion_cache import motion_key
from sim.pool import LocalTasks, Tasks, in_process
from sim.scenario import Scenario
from sim.simulation import plan

Progress = Callable[[float, int], object]
"""Called with (runs done, runs in all); runs in this process count by the share done."""
Warn = Callable[[str], object]
"""Called with a warning, a single line."""
LOOKED_AT = 8
"""Runs whose motions are compared, to see whether it is worth to keep motions in memory."""


def generate(
    scenario: Scenario,
    out: Place,
    *,
    runs: int = 1,
    seed: int | None = None,
    jobs: int = 1,
    split: str | None = None,
    runs_per_file: int = 1,
    engine: Tasks | None = None,
    progress: Progress = lambda done, total: None,
    warn: Warn = lambda text: None,
) -> Manifest:
    """Write OUT/dataset.json and OUT/run-00000.parquet ...; complete runs listed in an existing manifest are kept.

    split : shares of training, validation and test, such as "80/10/10"; the runs are then in OUT/data/train/ ..., each
        row has a run number, and OUT holds the files of `recordings.description`.
    runs_per_file : runs that share a file, OUT/runs-00000.parquet ..., whose rows have a run number; see
        `recordings.layout`. engine : computes and writes the files elsewhere, in place of `jobs` processes.

    The bytes depend on the scenario, the seed, the run and `runs_per_file` alone, never on `jobs` or engine. Returns
    the manifest. Raises InputError for a bad scenario or split, for an OUT with a different dataset, for an OUT locked
    by a running process, and when the system refuses to write.

    >>> from pathlib import Path
    >>> from sim.scenario import load
    >>> manifest = generate(load("tumble", ["phases.0.duration_s=60"]), Path("data"), runs=2)
    >>> [file.path for file in manifest.files], manifest.complete
    (['run-00000.parquet', 'run-00001.parquet'], True)
    """
    seed = scenario.seed if seed is None else seed
    if runs_per_file < 1:
        raise InputError(f"{runs_per_file} is too few", where="--runs-per-file", do="give 1 or more")
    layout = DatasetLayout(None if split is None else split_from(split, seed), runs_per_file)
    with locked_directory(out):
        return write_runs(DatasetPlan(scenario, out, runs, seed, layout), jobs, progress, warn, engine)


@dataclass(frozen=True)
class DatasetPlan:
    """A dataset to be written."""

    scenario: Scenario
    out: Place
    runs: int
    seed: int
    layout: DatasetLayout = field(default_factory=DatasetLayout)

    @property
    def table(self) -> tuple[Column, ...]:
        """Columns of a file."""
        columns = plan(self.scenario, 0, self.seed).columns
        return (RUN, *columns) if self.layout.numbered else columns

    @property
    def repeated(self) -> bool:
        """Whether some of the first runs share a motion."""
        keys = [motion_key(plan(self.scenario, run, self.seed)) for run in range(min(self.runs, LOOKED_AT))]
        return len(set(keys)) < len(keys)

    def begin(self, warn: Warn, pool: Tasks) -> list[int]:
        """Begin or resume the dataset; return the first runs of the files to write."""
        return open_dataset_for_writing(
            *(self.out, as_dict(self.scenario), self.seed, self.runs, self.table, warn),
            split=self.layout.split,
            runs_per_file=self.layout.runs_per_file,
            checker=partial(_checked, pool=pool),
        )

    def tasks(self, firsts: Sequence[int], shared: bool) -> list[FileTask]:
        """Return the tasks that write the files; `shared` where several machines write."""
        files = [self.layout.file_of(first, self.runs) for first in firsts]
        kept = len(firsts) > 0 and self.runs > 1 and self.repeated
        how = (self.layout.numbered, self.layout.runs_per_file > 1, kept, shared)
        return [FileTask(self.scenario, file, self.seed, self.out, *how) for file in files]


def write_runs(
    dataset: DatasetPlan, jobs: int, progress: Progress, warn: Warn = lambda text: None, engine: Tasks | None = None
) -> Manifest:
    """`generate` for a caller that already holds `locked_directory(out)`."""
    pool = engine or LocalTasks(jobs)
    tasks = dataset.tasks(dataset.begin(warn, pool if engine else LocalTasks(1)), shared=engine is not None)
    found: list[RunFile] = []

    done = dataset.runs - sum(len(task.file.runs) for task in tasks)

    def advance(part: float = 0.0) -> None:
        progress(done + part, dataset.runs)

    advance()
    write = partial(write_file, advance=advance) if engine is None and in_process(tasks, jobs) else write_file
    try:
        with closing(pool.map(write, tasks)) as results:
            for task, file in results:
                found.append(file)
                done += len(task.file.runs)
                advance()
    except BaseException:  # an interruption too: the workers are gone, and what they had in hand
        _clean(dataset.out)
        raise
    if engine is not None:
        _clean(dataset.out)
    return finish_dataset(dataset.out, found)


def _checked(checks: Iterable[FileCheck], pool: Tasks) -> Checked:
    return pool.map(check_file, list(checks))


def _clean(out: Place) -> None:
    for folder in folders(out):
        remove_leftovers(folder)
