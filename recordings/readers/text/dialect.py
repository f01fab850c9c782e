"""How a text log separates cells and writes decimals, found from its first lines."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from recordings.readers.text.words import CLOCK, DATE, is_comment, is_value

FIRST_LINES, FURTHER_LINES = 30, 60
"""Lines of the head by which the dialect is judged: the first, and others evenly below."""
BLANKS = " "
_DIGIT, _DATE, _CLOCK = re.compile(r"\d"), re.compile(DATE), re.compile(CLOCK)


@dataclass(frozen=True)
class Dialect:
    """How a line becomes cells.

    Parameters
    ----------
    delimiter : between cells; BLANKS for any run of blanks and tabs.
    decimal : the decimal mark, a point or a comma.
    quoted : whether cells may stand in double quotes.
    """

    delimiter: str
    decimal: str = "."
    quoted: bool = False

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, without surrounding blanks and quotes."""
        if self.quoted and '"' in line:
            (cells,) = csv.reader([line.strip("\r\n ")], delimiter=self.delimiter, skipinitialspace=True)
            return [cell.strip() for cell in cells]
        parts = line.split() if self.delimiter == BLANKS else line.strip("\r\n").split(self.delimiter)
        return [part.strip() for part in parts]

    def is_value(self, cell: str) -> bool:
        """Return whether the cell is a number or a time."""
        return is_value(cell, self.decimal)

    def merit(self, line: str) -> int:
        """Return the number of numbers and times in a line, less the cells in which digits are no number.

        A date and the clock behind a blank do not count: they may be one cell of a table with tabs.
        """
        cells = self.cells(line)
        found = sum(1 if self.is_value(cell) else -1 for cell in cells if _DIGIT.search(cell))
        return found - (2 * sum(map(_is_stamp, pairwise(cells))) if self.delimiter == BLANKS else 0)

    def is_comment(self, line: str) -> bool:
        """Return whether the line is blank or a comment."""
        return is_comment(line, self.delimiter)


def _is_stamp(cells: tuple[str, str]) -> bool:
    """Return whether two cells are a date and a clock."""
    return bool(_DATE.fullmatch(cells[0]) and _CLOCK.fullmatch(cells[1]))


CANDIDATES = (
    Dialect(","),
    Dialect(";"),
    Dialect("\t"),
    Dialect("|"),
    Dialect(";", ","),
    Dialect("\t", ","),
    Dialect("|", ","),
    Dialect(BLANKS),
    Dialect(BLANKS, ","),
    Dialect(",", ",", quoted=True),
)
"""In the order of preference where several explain the lines equally well."""


def dialect_of(lines: Sequence[str], quoted: bool) -> Dialect:
    """Return the dialect in which the lines hold the most numbers and times.

    The right delimiter cuts a line into more numbers than any other and leaves no digits over: `0,5;1,5` is two numbers
    with semicolons and a decimal comma, and with commas two numbers about `5;1`.
    quoted : whether there are quotes in the file.
    """
    further = lines[FIRST_LINES:]
    judged = [*lines[:FIRST_LINES], *further[:: max(len(further) // FURTHER_LINES, 1)]]
    candidates = [replace(one, quoted=quoted) for one in CANDIDATES if quoted or not one.quoted]
    return max(candidates, key=lambda one: sum(one.merit(line) for line in judged if not one.is_comment(line)))


def named_delimiter(line: str) -> str | None:
    """Return the delimiter of a first line `sep=;`, as spreadsheets write it."""
    text = line.strip("\r\n").strip('"')
    return text[4:5] or None if text.lower().startswith("sep=") else None
