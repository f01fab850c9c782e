"""What engines cost and what a second core and a cluster are worth: trials a second, in windows that take turns."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from benchmarks.comparison import TWELVE, short_spiral, whole_design
from benchmarks.measure import Row
from validation.calibrating.selection import select_calibrators
from validation.comparison.cluster import Cluster
from validation.comparison.design import Design
from validation.comparison.engine import Engine, ProcessEngine, run_trials
from validation.comparison.journal import Journal

LEAST_SECOND_CORE, LEAST_CLUSTER, MOST_OWN = 1.8, 0.9, 0.03
ROUNDS, TRIALS, WARM = 3, 28, 4
"""Windows of each engine, trials in one, and those that come before its clock starts: a new process compiles."""
ADDRESS = "tcp://127.0.0.1:18786"


@dataclass(frozen=True)
class Speed:
    """Trials a second, and the processor time that the submitting process itself spends on one."""

    trials_s: float
    own_s: float


def rows(small: bool = False) -> list[Row]:
    """Return the rows of a second process, of a cluster of two local workers, and of the engine's own work."""
    if small:
        return _rows(Design.of(short_spiral(), select_calibrators(TWELVE[:2]), seed=1), 1, WARM + 2)
    return _rows(whole_design(), ROUNDS, TRIALS)


def _rows(design: Design, rounds: int, trials: int) -> list[Row]:
    with _cluster():
        engines: dict[str, Engine] = {"one": ProcessEngine(1), "two": ProcessEngine(2), "cluster": Cluster(ADDRESS)}
        measured = [{name: _speed(design, engine, trials) for name, engine in engines.items()} for _ in range(rounds)]
    one, two, cluster = (statistics.median(speeds[name].trials_s for speeds in measured) for name in engines)
    second = statistics.median(speeds["two"].trials_s / speeds["one"].trials_s for speeds in measured)
    share = statistics.median(speeds["cluster"].trials_s / speeds["two"].trials_s for speeds in measured)
    own_s = statistics.median(speeds["two"].own_s for speeds in measured)
    return [
        Row("comparison: two processes / one", second, LEAST_SECOND_CORE, True, f"{one:.2f} and {two:.2f} trials/s"),
        Row("comparison: cluster / two processes", share, LEAST_CLUSTER, True, f"{cluster:.2f} trials/s, Dask"),
        Row("comparison: engine / trials", own_s * one, MOST_OWN, False, f"{1e3 * own_s:.2f} ms a trial"),
    ]


def _speed(design: Design, engine: Engine, trials: int) -> Speed:
    """Of an engine that runs already."""
    with tempfile.TemporaryDirectory() as folder:
        found = run_trials(design, range(trials), engine, Journal.open(Path(folder), design.identity()))
        list(islice(found, WARM))
        start_s, own_s = time.perf_counter(), time.process_time()
        count = len(list(found))
        return Speed(count / (time.perf_counter() - start_s), (time.process_time() - own_s) / count)


@contextmanager
def _cluster() -> Iterator[None]:
    """A scheduler and two workers of one thread each, on this machine alone."""
    dask = [sys.executable, "-m", "dask"]
    port = ADDRESS.rsplit(":", maxsplit=1)[1]
    commands = [
        [*dask, "scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard"],
        *[[*dask, "worker", ADDRESS, "--nthreads", "1", "--no-dashboard"]] * 2,
    ]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    running = [subprocess.Popen(one, env=environment, stderr=subprocess.DEVNULL) for one in commands]
    try:
        yield
    finally:
        for process in running:
            process.terminate()
        for process in running:
            process.wait()
