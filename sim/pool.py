"""Independent tasks on this machine's cores; a worker that dies costs a repeat, not the result."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

MAX_REBUILDS = 5


def map_unordered(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int
) -> Generator[tuple[Item, Result], None, None]:
    """Yield (item, function(item)) as they finish, `jobs` at a time; one job runs in this process.

    The pool is rebuilt and unfinished items resubmitted when a worker dies; BrokenProcessPool is raised when that
    happens MAX_REBUILDS times without an item finishing between. On any other exception, an interruption too, the
    workers are ended at once.
    """
    if in_process(items, jobs):
        yield from ((item, function(item)) for item in items)
        return
    waiting, failures = dict(enumerate(items)), 0
    while waiting:
        others = multiprocessing.active_children()
        with _pool(min(jobs, len(waiting))) as pool:
            try:
                futures = {pool.submit(function, item): key for key, item in waiting.items()}
                for future in as_completed(futures):
                    result = future.result()
                    failures = 0
                    yield waiting.pop(futures[future]), result
            except BrokenProcessPool:
                failures += 1
                if failures > MAX_REBUILDS:
                    raise
            except BaseException:
                for worker in set(multiprocessing.active_children()) - set(others):
                    worker.kill()
                raise


def in_process(items: Sequence[object], jobs: int) -> bool:
    """Whether `map_unordered` works in this process: one job, or one item."""
    return min(jobs, len(items)) <= 1


def _pool(jobs: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("forkserver")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_serve)


def _serve() -> None:
    """In a worker: leave Ctrl-C to the program that started it, and end as soon as that is gone.

    So nobody writes behind a restart.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_watch, args=(parent.sentinel,), daemon=True).start()


def _watch(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
