"""Runs tests in a process of its own, in which the libraries are loaded but nothing of the program is."""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing import forkserver
from pathlib import Path
from typing import Any

import pytest

FOLDERS = (
    *("scenarios", "recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers", "magbench", "tests"),
)
HEAVY = (
    *("coverage", "hypothesis", "matplotlib.pyplot", "mujoco", "numba", "numpy", "pandas", "pyarrow.parquet"),
    *("pydantic", "pytest", "scipy.optimize", "scipy.spatial.transform", "scipy.stats"),
)
"""Loaded once and inherited by every run."""
STARTING_S = 60
"""Most CPU for imports and for finding the tests."""
SLOWER, SLACK_S = 5, 20
"""A test may take so many times what it took on the program as it is, and so much more; then it counts as endless."""
MOST_WALL_S = 1500
"""After which processes that wait for one another are ended."""


class Chosen:
    """A plugin of pytest: the tests that are named, in their order, each within its limit of CPU seconds.

    log: holds the test begun last.
    """

    def __init__(self, seconds: Mapping[str, float], compiling_s: float, log: Path) -> None:
        self.rank = {test: i for i, test in enumerate(seconds)}
        self.seconds, self.compiling_s, self.log = seconds, compiling_s, log
        _limit_cpu(STARTING_S + compiling_s)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Tests that are not chosen do not run."""
        chosen = [item for item in items if item.nodeid in self.rank]
        items[:] = sorted(chosen, key=lambda item: self.rank[item.nodeid])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file that cannot be read is what failed."""
        if report.failed:
            self.log.write_text(report.nodeid)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """A loop without end, a compiled one too, is ended by the system."""
        self.log.write_text(nodeid)
        _limit_cpu(SLOWER * self.seconds[nodeid] + SLACK_S + self.compiling_s)


@dataclass(frozen=True)
class Run:
    """The quick tests of some files in a copy of the tree, with a plugin made by plugin(*arguments) in the child."""

    root: Path
    files: Sequence[str]
    options: Sequence[str]
    plugin: Callable[..., object]
    arguments: tuple[Any, ...]

    def status(self) -> int:
        """That of pytest, or minus the signal that ended the process."""
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(list(HEAVY))
        process = context.Process(target=_child, args=(self,))
        process.start()
        process.join(MOST_WALL_S)
        if process.exitcode is not None:
            return process.exitcode
        assert process.pid is not None
        os.killpg(process.pid, signal.SIGKILL)
        process.join()
        return -signal.SIGKILL


def _child(run: Run) -> None:
    """Only the copy is seen, here and in the processes that tests start."""
    os.setpgid(0, 0)
    forkserver._forkserver.__init__()  # type: ignore[misc]  # workers of tests get a server of their own
    os.chdir(run.root)
    os.environ |= {"PYTHONPATH": str(run.root), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    for name in [name for name in sys.modules if name.split(".")[0] in (*FOLDERS, "benchmarks")]:
        del sys.modules[name]
    sys.path.insert(0, str(run.root))
    with open(".report", "w") as report, tempfile.TemporaryDirectory() as place:
        os.dup2(report.fileno(), 1)
        os.dup2(report.fileno(), 2)
        fixed = ["-q", "--tb=short", "-m", "not slow", "-p", "no:cacheprovider", "--basetemp", f"{place}/tests"]
        status = pytest.main([*fixed, *run.options, *run.files], plugins=[run.plugin(*run.arguments)])
    sys.exit(int(status))


def _limit_cpu(more_s: float) -> None:
    """End this process when it has taken so much more."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    limit_s = int(used.ru_utime + used.ru_stime + more_s) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (limit_s, resource.RLIM_INFINITY))
