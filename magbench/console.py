"""What the user sees: progress and tables on standard error, results on standard output."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

Report = Callable[[int, int], object]
"""Told (pieces done, pieces in all)."""
WIDTH = 160
"""Columns of a table that goes to a file."""
PLAIN_LINES = 10
"""Progress lines for a whole piece of work where there is no terminal."""
messages = Console(stderr=True, soft_wrap=True, highlight=False)


def say(text: str) -> None:
    """A line for people, on standard error."""
    messages.print(text, markup=False)


def warn(text: str) -> None:
    """A line about something that is amiss though the command goes on; nothing for an empty text."""
    if text:
        say(f"magbench: {text}")


def emit(result: Mapping[str, Any]) -> None:
    """The one JSON object of `--json`, on standard output; NaN becomes null."""
    json.dump(_plain(result), sys.stdout, indent=1, allow_nan=False, ensure_ascii=False)
    sys.stdout.write("\n")


def show_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: bool = True) -> None:
    """A table on standard output: the first column to the left, numbers to the right."""
    table = Table(title=title or None, title_justify="left")
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if numbers and index else "left", overflow="fold", no_wrap=not index)
    for row in rows:
        table.add_row(*row)
    width = None if sys.stdout.isatty() else WIDTH
    Console(width=width, highlight=False, markup=False).print(table)


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """A bar on a terminal, plain lines elsewhere."""
    if messages.is_terminal:
        # One long run is one piece: the spinner and the clock show that it goes on.
        pieces = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
        with Progress(SpinnerColumn(), TextColumn("{task.description}"), *pieces, console=messages) as bar:
            task = bar.add_task(what, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
    else:
        yield _PlainLines(what)


class _PlainLines:
    """A line at the start, at every tenth of the work, and at the end."""

    def __init__(self, what: str) -> None:
        self.what, self.shown = what, -1

    def __call__(self, done: int, total: int) -> None:
        tenth = done * PLAIN_LINES // max(total, 1)
        if tenth > self.shown:
            self.shown = tenth
            say(f"{self.what}: {done} of {total}")


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
