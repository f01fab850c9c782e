"""What the user sees: progress and tables on standard error, results on standard output."""

from __future__ import annotations

import json
import math
import os
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Any, Literal

import typer
from rich.box import HEAVY_HEAD, SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
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
FILE_WIDTH = 100
"""Columns of a table that goes to a file."""
INDENT = 2
"""Columns by which the cells of a list are indented."""
LINES_A_ROW = 4
"""Lines that a row of a table takes on average at most; a longer table becomes a list."""
PLAIN_INTERVAL_S = 5.0
"""Least time between progress lines where there is no terminal."""
PLAIN_SHARE = 0.25
"""Of a long work the next line comes after this share of the time that it has taken, so that a log stays short."""
messages = Console(stderr=True, soft_wrap=True, highlight=False, emoji=False)


def say(text: str) -> None:
    """A line for people, on standard error; a terminal gets it broken between words, a file whole."""
    messages.print(text, markup=False, soft_wrap=not messages.is_terminal)


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
    """Text on standard output, its lines broken between words where the width is known."""
    _results().print(text, soft_wrap=not _width_known())


def show_points(points: Sequence[tuple[str, str]]) -> None:
    """A line each point: its mark, then its text, broken lines indented below the text."""
    console = _results()
    grid = Table.grid(padding=(0, 1))
    for point in points:
        grid.add_row(*point)
    console.print(grid)


def show_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: bool = True) -> None:
    """A table on standard output: the first column to the left, numbers to the right.

    Where the width demands it heads stand a word a line, then columns without lines between them; a table that would
    break words all the same becomes a list, a line each cell.
    """
    console = _results()
    narrow = [head.replace(" ", "\n") for head in columns]
    wide: dict[str, Any] = {"box": HEAVY_HEAD}
    slim: dict[str, Any] = {"box": SIMPLE_HEAD, "padding": 0, "show_edge": False}
    for heads, style in ((columns, wide), (narrow, wide), (narrow, slim)):
        table = _table(title, heads, rows, style, numbers=numbers)
        lines = ["".join(part.text for part in line) for line in console.render_lines(table)]
        if _readable(lines, [*columns, *chain.from_iterable(rows)], len(rows)):
            console.print(table)
            return
    console.print(*_as_list(title, columns, rows), sep="\n")


def _table(
    title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], style: Mapping[str, Any], *, numbers: bool
) -> Table:
    spread = any("\n" in cell for row in rows for cell in row)
    table = Table(title=title or None, title_justify="left", show_lines=spread, **style)
    for index, head in enumerate(heads):
        justify: Literal["left", "right"] = "right" if numbers and index else "left"
        table.add_column(head, justify=justify, overflow="fold", no_wrap=not index)
    for row in rows:
        table.add_row(*row)
    return table


def _readable(lines: Sequence[str], cells: Sequence[str], rows: int) -> bool:
    """Whether no word of a drawn table is broken, no row of a matrix, and no row of the table runs over many lines."""
    parts = [part.strip() for cell in cells if "\n" in cell for part in cell.splitlines()]
    if len(lines) > LINES_A_ROW * (rows + 2) or not all(any(part in line for line in lines) for part in parts):
        return False
    drawn, words = Counter(" ".join(lines).split()), Counter(word for cell in cells for word in cell.split())
    return words <= drawn


def _results() -> Console:
    """The console of standard output, as wide as the terminal or COLUMNS says, else FILE_WIDTH."""
    return Console(width=None if _width_known() else FILE_WIDTH, highlight=False, markup=False, emoji=False)


def _width_known() -> bool:
    return sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdecimal()


def _as_list(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[Padding | str]:
    """The rows of a table one after the other: the first cell, then each filled cell behind its column's head."""
    if title:
        yield title
    for first, *cells in rows:
        yield f"{columns[0]}: {first}" if columns[0] else first
        for head, cell in zip(columns[1:], cells, strict=True):
            if cell:
                yield Padding(f"{head}: {cell}" if head else cell, (0, 0, 0, INDENT), expand=False)


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """A bar on a terminal, which goes at the end; elsewhere plain lines, also from a step that reports nothing."""
    if messages.is_terminal:
        # The spinner and the clock show that a step which cannot tell its progress goes on.
        pieces = (BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), TimeRemainingColumn())
        words = (SpinnerColumn(), TextColumn("{task.description}"))
        with Progress(*words, *pieces, console=messages, transient=True) as bar:
            task = bar.add_task(what, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
        return
    lines, ended = PlainLines(what), threading.Event()
    ticking = threading.Thread(target=_tick, args=(lines, ended), daemon=True)
    ticking.start()
    try:
        yield lines
    finally:
        ended.set()
        ticking.join()


def _tick(lines: PlainLines, ended: threading.Event) -> None:
    while not ended.wait(PLAIN_INTERVAL_S / 5):
        lines.remind()


class PlainLines:
    """Lines of a work at its first report, each PLAIN_INTERVAL_S and then ever rarer, and at its end."""

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        self.what, self.clock = what, clock
        self.begun_s = self.told_s = clock()
        self.part: float | None = None

    def __call__(self, done: float, total: int) -> None:
        """Report a part done; the first and the last report are told at once."""
        first, self.part = self.part is None, done / max(total, 1)
        if first or done >= total:
            self._tell(self.clock())
        else:
            self.remind()

    def remind(self) -> None:
        """Tell how far the work is where the last line is PLAIN_INTERVAL_S old."""
        now_s = self.clock()
        if now_s - self.told_s >= max(PLAIN_INTERVAL_S, PLAIN_SHARE * (self.told_s - self.begun_s)):
            self._tell(now_s)

    def _tell(self, now_s: float) -> None:
        self.told_s = now_s
        passed = f"{math.floor(now_s - self.begun_s)} s"
        say(f"{self.what}: {passed if self.part is None else f'{math.floor(100 * self.part)} %, {passed}'}")
