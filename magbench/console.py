"""What the user sees: progress and tables on standard error, results on standard output."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from scenarios.errors import InputError
from scenarios.plain import json_ready

Report = Callable[[float, int], object]
"""Told (pieces done, pieces in all); a piece may be done in part."""
WIDTH = 160
"""Columns of a table that goes to a file."""
PLAIN_INTERVAL_S = 10.0
"""Time between progress lines where there is no terminal."""
messages = Console(stderr=True, soft_wrap=True, highlight=False)


def say(text: str) -> None:
    """A line for people, on standard error."""
    messages.print(text, markup=False)


def warn(text: str) -> None:
    """A line about something that is amiss though the command goes on; nothing for an empty text."""
    if text:
        say(f"magbench: {text}")


def end_with(failures: Sequence[str], refused: InputError | None = None) -> None:
    """End with status 1 and a line for each failure, or as `refused` does; go on where there is none."""
    for failure in failures:
        warn(failure)
    if refused:
        raise refused
    if failures:
        raise typer.Exit(1)


def emit(result: Mapping[str, Any]) -> None:
    """The one JSON object of `--json`, on standard output; NaN becomes null."""
    ascii_only = "utf" not in (sys.stdout.encoding or "").lower()
    json.dump(json_ready(result), sys.stdout, indent=1, allow_nan=False, ensure_ascii=ascii_only)
    sys.stdout.write("\n")


def show_text(text: str) -> None:
    """Text on standard output, its lines broken between words."""
    Console(width=None if sys.stdout.isatty() else WIDTH, highlight=False, markup=False).print(text)


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
        # The spinner and the clock show that a step which cannot tell its progress goes on.
        pieces = (BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), TimeRemainingColumn())
        with Progress(SpinnerColumn(), TextColumn("{task.description}"), *pieces, console=messages) as bar:
            task = bar.add_task(what, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
    else:
        yield PlainLines(what)


class PlainLines:
    """A line at the start, one each PLAIN_INTERVAL_S as long as the work goes on, and one at the end."""

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        self.what, self.clock, self.due_s = what, clock, -math.inf

    def __call__(self, done: float, total: int) -> None:
        if done >= total or self.clock() >= self.due_s:
            self.due_s = self.clock() + PLAIN_INTERVAL_S
            say(f"{self.what}: {math.floor(100 * done / max(total, 1))} %")
