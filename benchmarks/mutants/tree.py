"""A copy of the tree in which a file is changed, the tests are run, and the file is put back."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.mutants.changes import Mutant
from benchmarks.mutants.covering import Imports

MOST_WALL_S = 1800
FOLDERS = ("scenarios", "sim", "calib", "validation", "magbench", "tests")
HEAVY = ("numpy", "scipy.optimize", "scipy.spatial.transform", "scipy.stats", "numba", "pyarrow.parquet", "mujoco")
"""Loaded once and inherited by every run."""
KERNEL = re.compile(r"numba|kernel")
FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)


@dataclass(frozen=True)
class Told:
    """What a run of tests gave: `status` as pytest's, negative where the process was ended; the first failed test."""

    status: int
    failed: str
    wall_s: float


@dataclass(frozen=True)
class Tree:
    """A copy of the tracked files; most_cpu_s: of one run."""

    root: Path
    imports: Imports
    most_cpu_s: int

    @classmethod
    def copied(cls, original: Path, place: Path, most_cpu_s: int) -> Tree:
        """Copy what git tracks, as it stands in the working tree, and what numba has compiled of it."""
        names = subprocess.run(["git", "ls-files", "-z"], cwd=original, capture_output=True, text=True, check=True)
        tracked = [original / name for name in filter(None, names.stdout.split("\0"))]
        for file in (*tracked, *_compiled(original)):
            if file.is_file():
                copy = place / file.relative_to(original)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, copy)
        return cls(place, Imports.read(place, FOLDERS), most_cpu_s)

    def text(self, path: str) -> str:
        """A file's text."""
        return (self.root / path).read_text(encoding="utf-8")

    def run(self, tests: Sequence[str], left_out: Sequence[str] = ()) -> Told:
        """The quick tests of some files or names, up to the first that fails, in a fresh process."""
        report, start = self.root / ".report", time.monotonic()
        report.write_text("")
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(list(HEAVY))
        work = (str(self.root), list(tests), list(left_out), self.most_cpu_s)
        process = context.Process(target=_tests, args=work, daemon=True)
        process.start()
        process.join(MOST_WALL_S)
        if process.is_alive() and process.pid is not None:
            os.killpg(process.pid, signal.SIGKILL)
            process.join()
        failed = FAILED.search(report.read_text(errors="replace"))
        status = process.exitcode if process.exitcode is not None else -signal.SIGKILL
        return Told(status, failed[1] if failed else "", time.monotonic() - start)

    @contextlib.contextmanager
    def changed(self, mutant: Mutant) -> Iterator[None]:
        """The tree with the mistake in it.

        Numba keeps compiled loops by the date of the file that they stand in, not of those that they call: where the
        file holds kernels, all that import it are made to look new, and what was compiled is put back afterwards.
        """
        target, text = self.root / mutant.path, self.text(mutant.path)
        users = [self.root / name for name in self.imports.users(mutant.path) if not name.startswith("tests/")]
        with _dates_kept(users), _compiled_kept(self.root, users) if KERNEL.search(text) else contextlib.nullcontext():
            try:
                target.write_text(mutant.applied(text), encoding="utf-8")
                yield
            finally:
                target.write_text(text, encoding="utf-8")


@contextlib.contextmanager
def _dates_kept(files: Sequence[Path]) -> Iterator[None]:
    dates = {file: file.stat().st_mtime_ns for file in files}
    try:
        yield
    finally:
        for file, date_ns in dates.items():
            os.utime(file, ns=(date_ns, date_ns))


@contextlib.contextmanager
def _compiled_kept(root: Path, users: Sequence[Path]) -> Iterator[None]:
    """Files made to look new; afterwards numba's files are those of before."""
    kept = {file: file.read_bytes() for file in _compiled(root)}
    for user in users:
        os.utime(user)
    try:
        yield
    finally:
        for file in _compiled(root):
            file.unlink()
        for file, content in kept.items():
            file.write_bytes(content)


def _compiled(root: Path) -> list[Path]:
    """Numba's files."""
    return [file for folder in FOLDERS for file in (root / folder).rglob("__pycache__/*.nb[ci]")]


def _tests(root: str, tests: list[str], left_out: list[str], most_cpu_s: int) -> None:
    """In the child: only the copy is seen, here and in the processes that tests start."""
    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_CPU, (most_cpu_s, most_cpu_s + 5))
    os.chdir(root)
    os.environ |= {"PYTHONPATH": root, "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    import pytest

    for name in [name for name in sys.modules if name.split(".")[0] in (*FOLDERS, "benchmarks")]:
        del sys.modules[name]
    sys.path.insert(0, root)
    with open(f"{root}/.report", "w") as report:
        os.dup2(report.fileno(), 1)
        os.dup2(report.fileno(), 2)
        options = ["-x", "-q", "-rfE", "--tb=no", "-m", "not slow", "-p", "no:cacheprovider", "--basetemp"]
        with tempfile.TemporaryDirectory() as place:
            skipped = [f"--deselect={name}" for name in left_out]
            status = int(pytest.main([*options, f"{place}/tests", *skipped, *tests]))
    sys.exit(status)
