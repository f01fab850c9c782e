"""Engine that computes trials on an existing Dask cluster and collects the results here."""

from __future__ import annotations

import logging
import math
import time
from asyncio import CancelledError
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from itertools import chain, count, islice
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from scenarios.errors import InputError
from validation.comparison.engine import GoneError, Trials
from validation.comparison.trial import PendingTrial, Trial, compute

AHEAD = 2
"""Tasks submitted ahead for each worker thread, so that no thread waits for work."""
PATIENCE_S = 60.0
"""Time to wait for a lost scheduler, or for a scheduler without workers."""
LOOK_S = 1.0
"""Time between checks of the cluster while no trial arrives."""
CONNECT_S = 5.0
"""Time limit of a connection attempt."""
RESUME = "start it again, and repeat the command: it resumes"
ENDED = "every worker that had this task in hand was ended, perhaps for want of memory"
Item = TypeVar("Item")
Result = TypeVar("Result")


class DisconnectedError(Exception):
    """The scheduler stopped answering; submitted tasks must be submitted again."""


@dataclass(frozen=True)
class Cluster:
    """Dask cluster with a scheduler at `address`; workers that die or join late change no result."""

    address: str
    patience_s: float = PATIENCE_S

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        """Yield the trial of every task, see `map`."""
        with closing(self.map(compute, tasks, on_loss)) as found:
            yield from (trial for _, trial in found)

    def map(
        self,
        function: Callable[[Item], Result],
        items: Iterable[Item],
        on_loss: Callable[[Item], Result] | None = None,
    ) -> Generator[tuple[Item, Result], None, None]:
        """Yield (item, function(item)); losses of workers or scheduler shorter than `patience_s` are survived.

        on_loss : makes the result of an item that ended its worker repeatedly; without it InputError is raised.
        Raises InputError where distributed is not installed, and where scheduler or workers stay away longer.
        """
        _check_installed()
        source, again = iter(items), list[Item]()
        with _quiet():
            while True:
                connection = _Connection(self, function, on_loss)
                try:
                    yield from connection.results(chain(again, source))
                    return
                except DisconnectedError:
                    again = connection.pending()
                finally:
                    connection.close()

    def missing(self, what: str) -> GoneError:
        """Return the error that ends the comparison."""
        return GoneError(f"{what} for {self.patience_s:g} s", where=f"--scheduler {self.address}", do=RESUME)


@dataclass
class _Connection(Generic[Item, Result]):
    """A connection to the scheduler with the tasks submitted through the connection."""

    cluster: Cluster
    function: Callable[[Item], Result]
    on_loss: Callable[[Item], Result] | None
    submitted: dict[str, tuple[Any, Item]] = field(default_factory=dict)
    landed: SimpleQueue[str] = field(default_factory=SimpleQueue)

    def __post_init__(self) -> None:
        self.client = _connected(self.cluster)
        self._looked_s, self._numbers = -math.inf, count()

    def pending(self) -> list[Item]:
        """Return the submitted tasks without a result."""
        return [task for _, task in self.submitted.values()]

    def close(self) -> None:
        """Close the client; errors of a lost scheduler are ignored."""
        with suppress(Exception):
            self.client.close(timeout=CONNECT_S)

    def results(self, source: Iterator[Item]) -> Iterator[tuple[Item, Result]]:
        """Submit a bounded number of tasks ahead and yield (task, result) as results arrive."""
        while True:
            ahead = AHEAD * max(1, self._threads())
            for task in islice(source, max(0, ahead - len(self.submitted))):
                self._submit(task)
            if not self.submitted:
                return
            key = self._next()
            future, task = self.submitted[key]
            yield task, self._result(future, task)
            del self.submitted[key]

    def _submit(self, task: Item) -> None:
        key = f"{self.function.__name__}-{next(self._numbers)}-{id(self):x}"
        future = self.client.submit(self.function, task, key=key, pure=False)
        self.submitted[key] = (future, task)
        future.add_done_callback(lambda done: self.landed.put(done.key))

    def _next(self) -> str:
        """Return the key of the next finished task; GoneError without a worker for `patience_s`."""
        alone_since_s = time.monotonic()
        while True:
            with suppress(Empty):
                return self.landed.get(timeout=LOOK_S)
            if self._threads():
                alone_since_s = time.monotonic()
            elif time.monotonic() - alone_since_s > self.cluster.patience_s:
                raise self.cluster.missing("has had no worker")

    def _threads(self) -> int:
        """Return the threads of all workers, updated every LOOK_S; DisconnectedError without an answer."""
        if self.client.status != "running":
            raise DisconnectedError
        if time.monotonic() - self._looked_s >= LOOK_S:
            try:
                self._thread_count: int = sum(self.client.ncores().values())
            except Exception as error:
                raise DisconnectedError from error
            self._looked_s = time.monotonic()
        return self._thread_count

    def _result(self, future: Any, task: Item) -> Result:
        from distributed import KilledWorker

        if future.status not in ("finished", "error"):
            raise DisconnectedError
        try:
            found: Result = future.result(timeout=self.cluster.patience_s)
        except KilledWorker:
            if self.on_loss is None:
                raise InputError(ENDED, where=self.cluster.address, do=RESUME) from None
            return self.on_loss(task)
        except ModuleNotFoundError as error:
            do = "install on every machine what this one has, calibrators of your own too"
            raise InputError(f"a worker has no module {error.name}", where=self.cluster.address, do=do) from None
        except (Exception, CancelledError) as error:
            if future.status == "error":  # the task's own
                raise
            raise DisconnectedError from error
        return found


def _check_installed() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError:
        do = "pip install 'magbench[cluster]'"
        raise InputError("needs the package distributed", where="--scheduler", do=do) from None


def _connected(cluster: Cluster) -> Any:
    """Return a client of the scheduler; InputError where no scheduler answers within `patience_s`."""
    from distributed import Client

    end_s = time.monotonic() + cluster.patience_s
    while True:
        try:
            return Client(cluster.address, timeout=CONNECT_S, set_as_default=False, name="magbench")
        except ValueError as error:
            what = " ".join(str(error).split())
            raise InputError(what, where=f"--scheduler {cluster.address}", do="write tcp://host:8786") from None
        except Exception:
            if time.monotonic() > end_s:
                raise cluster.missing("has not answered") from None
            time.sleep(LOOK_S)


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence Dask's log lines and tracebacks about lost connections; the engine reports losses in a single line."""
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
