"""Linear algebra in one thread: of small matrices a pool of threads waits longer than it computes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread within: sums over several are rounded in another order, and on a busy machine they wait."""
    with _threads().limit(limits=1):
        yield


@lru_cache(maxsize=1)
def _threads() -> ThreadpoolController:
    """The linear algebra libraries of this process; finding them takes longer than a small trial."""
    return ThreadpoolController()
