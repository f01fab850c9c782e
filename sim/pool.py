"""Independent tasks in worker processes; a task whose worker dies is repeated."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import chain, islice
from multiprocessing.connection import wait
from typing import Generic, Protocol, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

SUSPECT = 2
"""Deaths of workers with an item in hand, after which the item is tried alone."""
ALONE = 2
"""Deaths of workers with the item alone, after which the item is given up."""
AHEAD = 2
"""Items submitted at a time for each worker: enough to keep workers busy, few enough for a million items."""

START_METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
"""Start of workers: from a clean server process on POSIX systems, each from a new interpreter on Windows."""


class Tasks(Protocol):
    """Computes a function of items anywhere, in any order."""

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Generator[tuple[Item, Result], None, None]:
        """Yield (item, function(item)) in order of completion; closing the generator ends the work."""


@dataclass(frozen=True)
class LocalTasks:
    """`jobs` processes of this machine; a single job, or a single item, is computed in this process."""

    jobs: int = 1

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Generator[tuple[Item, Result], None, None]:
        """Compute by `map_unordered`."""
        yield from map_unordered(function, items, self.jobs)


@dataclass(frozen=True)
class _Try(Generic[Item]):
    """An item, and the number of workers that died with the item in hand."""

    item: Item
    deaths: int = 0


def map_unordered(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    jobs: int,
    lost: Callable[[Item], Result] | None = None,
) -> Generator[tuple[Item, Result], None, None]:
    """Yield (item, function(item)) in order of completion, `jobs` at a time; items are taken as needed.

    When a worker dies, the pool is rebuilt and the items in hand are submitted again. An item in hand at SUSPECT deaths
    is tried alone, to spare the neighbours; after ALONE further deaths lost(item) is the result, or without `lost`
    BrokenProcessPool is raised. On any different exception or an interruption the workers are ended at once. Without
    `lost` a single job, or a single item, runs in this process.
    """
    if lost is None and isinstance(items, Sequence) and in_process(items, jobs):
        yield from ((item, function(item)) for item in items)
        return
    yield from _pooled(function, map(_Try, items), jobs, lost)


def in_process(items: Sequence[object], jobs: int) -> bool:
    """Whether `map_unordered` works without worker processes: a single job, or a single item."""
    return min(jobs, len(items)) <= 1


def _pooled(
    function: Callable[[Item], Result], fresh: Iterator[_Try[Item]], jobs: int, lost: Callable[[Item], Result] | None
) -> Generator[tuple[Item, Result], None, None]:
    again = yield from _until_a_death(function, fresh, jobs)
    while again:
        together = []
        for one in again:
            if one.deaths == SUSPECT:
                yield one.item, _alone(function, one.item, lost)
            else:
                together.append(one)
        again = yield from _until_a_death(function, chain(together, fresh), jobs)


def _until_a_death(
    function: Callable[[Item], Result], tries: Iterator[_Try[Item]], jobs: int
) -> Generator[tuple[Item, Result], None, list[_Try[Item]]]:
    """Yield results until the end, or until a worker dies; return the items then in hand."""
    first = list(islice(tries, AHEAD * jobs))
    if not first:
        return []
    hand: dict[Future[Result], _Try[Item]] = {}
    todo = deque(first)
    with _workers(min(jobs, len(first))) as pool:
        try:
            while todo or hand:
                while todo:
                    hand[pool.submit(function, todo[0].item)] = todo[0]
                    todo.popleft()
                for future in wait_for(hand, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    yield hand.pop(future).item, result
                todo.extend(islice(tries, AHEAD * jobs - len(hand)))
        except BrokenProcessPool:
            return [*todo, *(_Try(one.item, one.deaths + 1) for one in hand.values())]
    return []


def _alone(function: Callable[[Item], Result], item: Item, lost: Callable[[Item], Result] | None) -> Result:
    for _ in range(ALONE):
        with _workers(1) as pool:
            pool.submit(os.getpid).result()  # a process that cannot even start is not the item's doing
            with suppress(BrokenProcessPool):
                return pool.submit(function, item).result()
    if lost is None:
        raise BrokenProcessPool(f"{ALONE} processes ended that worked on {item!r}")
    return lost(item)


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """A pool whose workers are ended at once on any exception."""
    others = multiprocessing.active_children()
    context = multiprocessing.get_context(START_METHOD)
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_serve) as pool:
        try:
            yield pool
        except BaseException:
            for worker in set(multiprocessing.active_children()) - set(others):
                worker.kill()
            raise


def _serve() -> None:
    """Initialise a worker: ignore Ctrl-C, and end as soon as the parent process has ended.

    An orphaned worker would write into a restarted run.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_watch, args=(parent.sentinel,), daemon=True).start()


def _watch(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
