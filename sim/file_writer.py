"""Writer of a dataset's file: one run, or several, simulated and written block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from recordings.columns import RUN, schema
from recordings.files import canonical_json
from recordings.layout import DatasetFile
from recordings.metadata import FileRun, RunFile, TrueParameters, run_file, run_metadata
from recordings.url_path import Place
from recordings.writer import RunWriter
from scenarios.toml import as_dict
from sim.motion import Motion
from sim.motion_cache import MotionCache
from sim.scenario import Scenario
from sim.simulation import Block, blocks, plan, true_motion
from sim.tracking import Tracker, together

MOTIONS = MotionCache()
"""Cache of simulated motions in the process."""
Advance = Callable[[float], object]
"""Called with the runs done, as a fraction."""


@dataclass(frozen=True)
class FileTask:
    """A file to be written, in the form sent to a worker.

    numbered : whether each row has the number of its run. several : whether the file is of a dataset with several runs
        a file. repeated : whether runs share motions, which are then kept.
    shared : whether another machine may write the same file at the same time.
    """

    scenario: Scenario
    file: DatasetFile
    seed: int
    out: Place
    numbered: bool = False
    several: bool = False
    repeated: bool = False
    shared: bool = False


def write_file(task: FileTask, advance: Advance = lambda part: None) -> RunFile:
    """Simulate the runs of a file and write it; return its entry in the manifest.

    Raises InputError where the vehicle cannot follow the motion, and where the system refuses to write.
    """
    first = plan(task.scenario, task.file.first, task.seed)
    metadata = run_metadata(as_dict(task.scenario), task.seed, first.run, {}) if task.several else first.metadata
    table = (RUN, *first.columns) if task.numbered else first.columns
    path = task.out / task.file.path
    with RunWriter(path, schema(table), metadata, shared=task.shared) as writer:
        held = [_write_run(writer, task, run, partial(_after, advance, k)) for k, run in enumerate(task.file.runs)]
        if task.several:
            writer.add_runs(held)
        writer.add_tracking(together(one.tracking for one in held) if task.several else held[0].tracking)
    return run_file(path, task.file.first, task.out)


def _after(advance: Advance, done: int, part: float) -> None:
    """Tell the progress of a run after `done` others."""
    advance(done + part)


def _write_run(writer: RunWriter, task: FileTask, run: int, advance: Advance) -> FileRun:
    """Simulate a run and append it to a file."""
    ready = plan(task.scenario, run, task.seed)
    tracker, rows = Tracker(ready.drawn.phases), 0

    def watched() -> Iterator[Motion]:
        for motion in MOTIONS.motions(ready) if task.repeated else true_motion(ready):
            tracker.see(motion)
            advance(_part(ready.drawn, motion))
            yield motion

    for block in blocks(ready, watched()):
        rows += len(block["time_s"])
        writer.write(_numbered(block, ready.run) if task.numbered else block)
    parameters = TrueParameters.model_validate_json(canonical_json(ready.metadata["parameters"]))
    return FileRun(run, rows, parameters, tracker.tracking)


def _numbered(block: Block, run: int) -> Block:
    return block | {RUN.name: np.full(len(block["time_s"]), run)}


def _part(scenario: Scenario, motion: Motion) -> float:
    """Share of the run's longest duration that has passed at the end of a block."""
    lengths_s = [phase.duration_s for phase in scenario.phases]
    return float((sum(lengths_s[: motion.phase]) + motion.phase_time_s[-1]) / sum(lengths_s))
