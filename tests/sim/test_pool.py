"""The pool gives every result once, whatever happens to its workers."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from pathlib import Path

import pytest

from sim import pool
from sim.pool import AHEAD, map_unordered


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


@pytest.mark.parametrize("method", sorted({pool.START_METHOD, "spawn"}))
@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_once(jobs: int, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """However workers start: Windows knows spawn alone."""
    monkeypatch.setattr(pool, "START_METHOD", method)
    assert dict(map_unordered(square, range(20), jobs)) == {x: x * x for x in range(20)}


@pytest.mark.parametrize("method", sorted({pool.START_METHOD, "spawn"}))
def test_a_killed_worker_costs_a_repeat_not_the_result(
    tmp_path: Path, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool, "START_METHOD", method)
    items = [tmp_path / str(k) for k in range(4)]
    assert dict(map_unordered(die_once, items, 2)) == {item: item.name for item in items}


def die_always(x: int) -> int:
    """Kills its worker for a multiple of five; others take a while, so that they are in hand when it dies."""
    if x % 5 == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return x


def test_an_item_that_ends_its_workers_is_given_up_and_its_neighbours_are_not() -> None:
    assert dict(map_unordered(die_always, range(1, 12), 2, lambda x: -x)) == {
        x: -x if x % 5 == 0 else x for x in range(1, 12)
    }


def test_without_anything_to_say_of_it_such_an_item_ends_the_work() -> None:
    with pytest.raises(BrokenProcessPool):
        list(map_unordered(die_always, [5, 1], 2))


def test_items_are_taken_as_they_are_needed() -> None:
    taken: list[int] = []

    def items() -> Iterator[int]:
        for x in range(1000):
            taken.append(x)
            yield x

    with closing(map_unordered(square, items(), 2)) as found:
        next(found)
    assert len(taken) <= 2 * AHEAD * 2


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
    """Whether it still runs; one that ends between the opening of its file and the reading does not."""
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().split(") ")[1][0] != "Z"
    except OSError:
        return False
