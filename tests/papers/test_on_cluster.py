"""The tasks of a reproduction on a cluster: the same results in the same order."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from typing import TypeVar

from papers.base import computed_on, run_tasks

Item = TypeVar("Item")
Result = TypeVar("Result")


class Backwards:
    """A cluster whose results arrive in the opposite order."""

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Generator[tuple[Item, Result], None, None]:
        """Compute the last item first."""
        yield from ((item, function(item)) for item in reversed(items))


def test_results_keep_their_order_whatever_computes_them() -> None:
    told: list[tuple[int, int]] = []
    work = [(abs, [-1, -2, 3]), (float, ["4", "5"])]
    with computed_on(Backwards()):
        found = run_tasks(work, 1, lambda done, total: told.append((done, total)))
    assert found == ([1, 2, 3], [4.0, 5.0]) == run_tasks(work, 1, lambda done, total: None)
    assert told == [(done, 5) for done in range(1, 6)]
