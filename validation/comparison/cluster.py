"""Trials on a Dask cluster that is there already: its workers compute, this process keeps."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import chain, islice
from queue import Empty, SimpleQueue
from typing import Any

from scenarios.errors import InputError
from validation.comparison.engine import GoneError, Trials
from validation.comparison.trial import PendingTrial, Trial, compute

AHEAD = 2
"""Tasks a worker's thread that are submitted at a time: none waits for work."""
PATIENCE_S = 60.0
"""How long a scheduler that is gone, or one without workers, is waited for."""
LOOK_S = 1.0
"""Time between looks at the cluster while no trial lands."""
CONNECT_S = 5.0
"""Time for one attempt to connect."""


class DisconnectedError(Exception):
    """The scheduler does not answer any more; what was in hand is to be submitted again."""


@dataclass(frozen=True)
class Cluster:
    """The Dask cluster whose scheduler is at `address`; a worker that dies, or joins late, changes no figure."""

    address: str
    patience_s: float = PATIENCE_S

    def trials(self, tasks: Iterable[PendingTrial], lost: Callable[[PendingTrial], Trial]) -> Trials:
        """The trial of every task, through losses of workers and of the scheduler that last less than `patience_s`.

        Raises InputError where distributed is not installed, and where scheduler or workers stay away.
        """
        _check_installed()
        source, again = iter(tasks), list[PendingTrial]()
        with _quiet():
            while True:
                hand = _Hand(self, lost)
                try:
                    yield from hand.trials(chain(again, source))
                    return
                except DisconnectedError:
                    again = hand.tasks()
                finally:
                    hand.close()

    def missing(self, what: str) -> GoneError:
        """What ends the comparison."""
        do = "start it again, and repeat the command: it resumes"
        return GoneError(f"{what} for {self.patience_s:g} s", where=f"--scheduler {self.address}", do=do)


@dataclass
class _Hand:
    """A connection, and the tasks that are submitted through it."""

    cluster: Cluster
    lost: Callable[[PendingTrial], Trial]
    submitted: dict[str, tuple[Any, PendingTrial]] = field(default_factory=dict)
    landed: SimpleQueue[str] = field(default_factory=SimpleQueue)

    def __post_init__(self) -> None:
        self.client = _connected(self.cluster)
        self._looked_s, self._known = -LOOK_S, 0

    def tasks(self) -> list[PendingTrial]:
        """What was submitted and has not been told."""
        return [task for _, task in self.submitted.values()]

    def close(self) -> None:
        """Give back what is not needed any more; errors of a scheduler that is gone do not matter."""
        with suppress(Exception):
            self.client.close(timeout=CONNECT_S)

    def trials(self, source: Iterator[PendingTrial]) -> Iterator[Trial]:
        """Submit a bounded number ahead, and yield what lands."""
        while True:
            ahead = AHEAD * max(1, self._threads())
            for task in islice(source, max(0, ahead - len(self.submitted))):
                self._submit(task)
            if not self.submitted:
                return
            key = self._next()
            future, task = self.submitted[key]
            yield self._result(future, task)
            del self.submitted[key]

    def _submit(self, task: PendingTrial) -> None:
        key = f"trial-{task.point}-{task.run}-{id(self):x}"
        future = self.client.submit(compute, task, key=key, pure=False)
        self.submitted[key] = (future, task)
        future.add_done_callback(lambda done: self.landed.put(done.key))

    def _next(self) -> str:
        """The key of the next that is done; GoneError where there is no worker for too long."""
        alone_since_s = time.monotonic()
        while True:
            with suppress(Empty):
                return self.landed.get(timeout=LOOK_S)
            if self._threads():
                alone_since_s = time.monotonic()
            elif time.monotonic() - alone_since_s > self.cluster.patience_s:
                raise self.cluster.missing("has had no worker")

    def _threads(self) -> int:
        """Threads of all workers, asked for now and then; DisconnectedError where the scheduler does not answer."""
        if self.client.status != "running":
            raise DisconnectedError
        if time.monotonic() - self._looked_s >= LOOK_S:
            try:
                self._known = sum(self.client.ncores().values())
            except Exception as error:
                raise DisconnectedError from error
            self._looked_s = time.monotonic()
        return self._known

    def _result(self, future: Any, task: PendingTrial) -> Trial:
        from distributed import KilledWorker

        if future.status not in ("finished", "error"):
            raise DisconnectedError
        try:
            trial: Trial = future.result()
        except KilledWorker:
            return self.lost(task)
        except ModuleNotFoundError as error:
            do = "install on every machine what this one has, calibrators of your own too"
            raise InputError(f"a worker has no module {error.name}", where=self.cluster.address, do=do) from None
        return trial


def _check_installed() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError:
        do = "pip install 'magbench[cluster]'"
        raise InputError("needs the package distributed", where="--scheduler", do=do) from None


def _connected(cluster: Cluster) -> Any:
    """A client of the scheduler; InputError where none answers for as long as one is waited for."""
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
    """Dask's own lines about lost connections, tracebacks among them, stay away: what matters is said in one line."""
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
