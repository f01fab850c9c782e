"""The rows of a text table as an Arrow table, and the lines that are no rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
from numpy.typing import NDArray

from recordings.readers.text.dialect import BLANKS, Dialect
from recordings.readers.text.words import SPELT, is_comment
from scenarios.errors import InputError

BLOCK_BYTES = 1 << 22
"""What Arrow reads at a time: its own default, 1 MiB, is some percent slower."""
MOST_TAIL = 2000
"""Bytes of the end in which a last line is compared with the lines above."""
_SPACE, _TAB, _LINE_FEED, _RETURN = b" \t\n\r"


@dataclass(eq=False)
class SkippedLines:
    """Lines that Arrow's reader left out since their cells are more or fewer than the columns.

    Parameters
    ----------
    delimiter : of the cells.
    numbers : of the lines, counted from 1 at the first row, without empty lines.
    fewer, more : those of them that are neither blank nor a comment.
    """

    delimiter: str
    numbers: list[int] = field(default_factory=list)
    fewer: list[int] = field(default_factory=list)
    more: list[int] = field(default_factory=list)

    def __call__(self, row: pyarrow.csv.InvalidRow) -> str:
        """Note an invalid row and have it skipped."""
        self.numbers.append(row.number)
        if not is_comment(row.text, self.delimiter):
            (self.fewer if row.actual_columns < row.expected_columns else self.more).append(row.number)
        return "skip"

    def numbers_of_rows(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of the lines at which rows of the table stand, rows counted from 0."""
        skipped = np.array(self.numbers, np.int64)
        before = skipped - np.arange(len(skipped))  # rows ahead of a skipped line, plus one
        return np.asarray(rows + 1 + np.searchsorted(before, rows + 1, "right"))


@contextmanager
def table_errors_about(path: Path) -> Iterator[None]:
    """Turn Arrow's errors about lines that cannot be cut into cells into an InputError about `path`."""
    try:
        yield
    except (pa.ArrowException, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())[:160]
        do = "convert it to a text table with a header line, or to Parquet"
        raise InputError(f"cannot be read as a text table: {reason}", where=str(path), do=do) from error


def parsed(data: memoryview, dialect: Dialect, columns: int, wanted: Sequence[int]) -> tuple[pa.Table, SkippedLines]:
    """Return the wanted columns, called by their numbers from 0, of lines of cells."""
    names = [str(k) for k in range(columns)]
    skipped = SkippedLines(dialect.delimiter)
    blanks = dialect.delimiter == BLANKS
    if not data:
        return pa.table({names[k]: pa.array([], pa.float64()) for k in wanted}), skipped
    table = pyarrow.csv.read_csv(
        pa.BufferReader(_squeezed(data) if blanks else data),
        read_options=pyarrow.csv.ReadOptions(use_threads=False, column_names=names, block_size=BLOCK_BYTES),
        parse_options=pyarrow.csv.ParseOptions(
            delimiter="\t" if blanks else dialect.delimiter,
            quote_char='"' if dialect.quoted else False,
            invalid_row_handler=skipped,
        ),
        convert_options=pyarrow.csv.ConvertOptions(
            null_values=SPELT,
            decimal_point=dialect.decimal,
            include_columns=[names[k] for k in wanted] or None,
        ),
    )
    return table, skipped


def complete_lines(data: memoryview, dialect: Dialect, columns: int) -> memoryview:
    """Return lines without a last line that was cut off while being written.

    A cut line has no line break, and fewer cells than columns, or fewer decimals at its end than the lines above.
    """
    tail = bytes(data[-MOST_TAIL:]).splitlines(keepends=True)
    if not tail or tail[-1].endswith((b"\n", b"\r")):
        return data
    above, last = [dialect.cells(line.decode("utf-8", "replace")) for line in tail[1:-1]], tail[-1]
    cells = dialect.cells(last.decode("utf-8", "replace"))
    decimals = {_decimals(row[columns - 1], dialect.decimal) for row in above if len(row) == columns}
    full = len(cells) >= columns and not (
        len(decimals) == 1 and _decimals(cells[columns - 1], dialect.decimal) < min(decimals)
    )
    return data if len(tail) < 2 or full else data[: -len(last)]


def _decimals(cell: str, decimal: str) -> int:
    return len(cell.partition(decimal)[2])


def line_of(data: memoryview, number: int) -> int:
    """Return the line, counted from 0, of the line of this number, counted from 1 without empty lines."""
    text = np.frombuffer(data, np.uint8)
    feed, carriage = text == _LINE_FEED, text == _RETURN
    ends = np.flatnonzero(feed | (carriage & ~np.r_[feed[1:], False]))
    starts = np.r_[0, ends + 1]
    lengths = np.diff(np.r_[starts, len(text) + 1]) - 1
    lengths[:-1] -= feed[ends] & carriage[ends - 1] & (ends > 0)
    return int(np.flatnonzero(lengths > 0)[number - 1])


def _squeezed(data: memoryview) -> bytes:
    """Return lines with a tab for each run of blanks, and without blanks at their ends."""
    text = np.frombuffer(data, np.uint8)
    blank = (text == _SPACE) | (text == _TAB)
    gap = blank | (text == _LINE_FEED) | (text == _RETURN)
    once = np.where(blank, _TAB, text)[~(blank & np.r_[True, gap[:-1]])].astype(np.uint8)
    ends = np.r_[(once[1:] == _LINE_FEED) | (once[1:] == _RETURN), True]
    squeezed: bytes = once[~((once == _TAB) & ends)].tobytes()
    return squeezed
