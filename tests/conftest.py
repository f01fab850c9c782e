"""Shared fixtures."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from markupsafe import Markup

ROOT = Path(__file__).resolve().parent.parent
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a worker a core; before numpy is imported
    os.environ.setdefault(_name, "1")
for _number in (signal.SIGINT, signal.SIGHUP):  # ignored under nohup and in the background, and so in every child
    if signal.getsignal(_number) == signal.SIG_IGN:
        signal.signal(_number, signal.default_int_handler if _number == signal.SIGINT else signal.SIG_DFL)
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else each process that a test starts compiles 3,000 modules anew


gc.disable()  # until all tests are collected: their hundred thousands of objects are no garbage


def pytest_collection_finish() -> None:
    """Collect garbage from here on, and never go through what was there before."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def realdata() -> Path:
    """Folder of measured recordings, named by MAGBENCH_REALDATA; tests that need it skip where it is not set."""
    folder = os.environ.get("MAGBENCH_REALDATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("MAGBENCH_REALDATA does not name a folder of measured recordings")
    return Path(folder)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave figures out of pages: `tests/reports` draws those of every page, which takes longer than most commands."""
    monkeypatch.setattr("reports.pages.section.figure_html", lambda draw, title: Markup(""))


@pytest.fixture(scope="session")
def run_python() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run code in a fresh interpreter."""

    def run(code: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)

    return run


@pytest.fixture(scope="session")
def cli() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the installed command line as a user does."""

    def run(*arguments: str, **keywords: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "magbench", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=300, **keywords)  # type: ignore[call-overload, no-any-return]

    return run
