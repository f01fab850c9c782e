"""The pool gives every result once, whatever happens to its workers."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sim.pool import map_unordered


def square(x: int) -> int:
    return x * x


def die_once(path: Path) -> str:
    """Kills its own worker at the first try; succeeds at the second."""
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path.name


def fail(x: int) -> int:
    raise ValueError(f"no {x}")


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_once(jobs: int) -> None:
    assert dict(map_unordered(square, range(20), jobs)) == {x: x * x for x in range(20)}


def test_a_killed_worker_costs_a_repeat_not_the_result(tmp_path: Path) -> None:
    items = [tmp_path / str(k) for k in range(4)]
    assert dict(map_unordered(die_once, items, 2)) == {item: item.name for item in items}


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_exception_reaches_the_caller(jobs: int) -> None:
    with pytest.raises(ValueError, match="no "):
        list(map_unordered(fail, [1, 2, 3], jobs))


def test_workers_end_with_a_killed_parent(tmp_path: Path) -> None:
    code = (
        "import sys, time, os; sys.path.insert(0, sys.argv[1]); from sim.pool import map_unordered\n"
        "from tests_pool_helper import slow\n"
        "list(map_unordered(slow, [sys.argv[2] + str(k) for k in range(2)], 2))"
    )
    (tmp_path / "tests_pool_helper.py").write_text(
        "import time, os\ndef slow(path):\n    open(path, 'w').write(str(os.getpid()))\n    time.sleep(60)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path), str(tmp_path / "pid")])
    files = [tmp_path / f"pid{k}" for k in range(2)]
    _until(lambda: all(f.exists() and f.read_text() for f in files))
    workers = [int(f.read_text()) for f in files]
    parent.kill()
    parent.wait()
    _until(lambda: not any(_alive(pid) for pid in workers))


def _until(true, limit_s: float = 30.0) -> None:  # type: ignore[no-untyped-def]
    end = time.monotonic() + limit_s
    while not true():
        assert time.monotonic() < end, "did not happen in time"
        time.sleep(0.05)


def _alive(pid: int) -> bool:
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().split(") ")[1][0] != "Z"
    except FileNotFoundError:
        return False
