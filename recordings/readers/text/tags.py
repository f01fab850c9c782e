"""Logs in which a word of each line tells its sensor: `MAG,0.1,12.7,11.3,-18.3`, `Raw:0,0,8192,1,-2,0,127,114,-183`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

from recordings.readers.text.dialect import BLANKS, Dialect
from recordings.readers.text.sensors import kind_of, magnetometer_among
from recordings.readers.text.words import is_empty_mark, without_mark

MOST_BEFORE = 2
"""Cells ahead of the word: a time, a number of the line."""
MOST_ADDED = 3
"""Cells by which a word's header in the comments may differ from the word's lines."""
LEAST_SHARE = 0.6
"""Share of the lines with numbers that have a word, in a log of lines of several sensors."""
_WORD = re.compile(r"[$A-Za-z][\w./ -]*")
COLON = r'^((?:[^A-Za-z]*[,;|\s])?"?[A-Za-z$][\w./ -]*?"?)\s*:\s*'
"""The first word of a line, with a colon; times and numbers may stand before."""


@dataclass(frozen=True)
class TaggedLines:
    """How the lines of several sensors are told apart.

    Parameters
    ----------
    at : the cell of the word, counted from 0.
    widths : by word, the number of cells of most lines.
    rows : by word, the cells of the first lines.
    headers : by word, or by the empty word for all lines, the names of the cells.
    """

    at: int
    widths: dict[str, int]
    rows: dict[str, list[list[str]]]
    headers: dict[str, list[str]]

    def names(self, word: str) -> list[str]:
        """Return the names of a word's values in the file's header; empty where the file has none for it.

        A header of the word itself may be a few cells shorter or longer than its lines, as those of newer releases.
        """
        own, width = self.headers.get(word, []), self.widths[word]
        if own and abs(len(own) - width) <= MOST_ADDED:
            own = [*own, *[""] * (width - len(own))][:width]
        header = own or self.headers.get("") or []
        return [name for k, name in enumerate(header) if k != self.at] if len(header) == width else []

    @property
    def magnetometer(self) -> str | None:
        """The word of the magnetometer's lines; None where no word is known as a magnetometer's."""
        return magnetometer_among({word: width - 1 for word, width in self.widths.items()})

    @property
    def is_table(self) -> bool:
        """Whether the header names a magnetometer, so that the words are a column of their own."""
        return any(kind_of(name) == "mag" for name in self.headers.get("", ()))

    def pattern(self, word: str, dialect: Dialect) -> str:
        """Return the regular expression of a word's lines."""
        between = r"\s" if dialect.delimiter == BLANKS else re.escape(dialect.delimiter)
        before = rf"^\s*(?:[^{between}]*{between}\s*){{{self.at}}}"
        return rf'{before}"?{re.escape(word)}"?\s*(?:{between}|:)'


def tagged_lines(lines: Sequence[str], dialect: Dialect) -> TaggedLines | None:
    """Return how the lines of sensors are told apart; None where the lines have no such words."""
    plain = [with_delimiter(line, dialect) for line in lines if not dialect.is_comment(line)]
    split = [dialect.cells(line) for line in plain]
    rows = [cells for cells in split if any(map(dialect.is_value, cells))]
    for at in range(MOST_BEFORE + 1):
        of = _by_word(rows, at, dialect)
        if rows and sum(map(len, of.values())) >= LEAST_SHARE * len(rows):
            widths = {word: Counter(map(len, cells)).most_common(1)[0][0] for word, cells in of.items()}
            return TaggedLines(at, widths, of, _headers(lines, split, at, list(of), dialect))
    return None


def _by_word(rows: Sequence[list[str]], at: int, dialect: Dialect) -> dict[str, list[list[str]]]:
    """Return the rows by the word in a cell, of the words that occur twice or more."""
    of: dict[str, list[list[str]]] = {}
    for cells in rows:
        if len(cells) > at + 1 and _is_word(cells[at], dialect):
            of.setdefault(cells[at], []).append(cells)
    return {word: cells for word, cells in of.items() if len(cells) > 1}


def with_delimiter(line: str, dialect: Dialect) -> str:
    """Return a line with a delimiter in place of the colon after its first word."""
    return re.sub(COLON, lambda found: found[1] + dialect.delimiter, line, count=1)


def _is_word(cell: str, dialect: Dialect) -> bool:
    return bool(_WORD.fullmatch(cell)) and not is_empty_mark(cell) and not dialect.is_value(cell)


def _headers(
    lines: Sequence[str], split: Sequence[list[str]], at: int, words: Sequence[str], dialect: Dialect
) -> dict[str, list[str]]:
    """Return the header of all lines, the last above them without a value, and headers of a word in comments."""
    headers: dict[str, list[str]] = {}
    above = takewhile(lambda cells: len(cells) <= at or cells[at] not in words, split)
    for cells in above:
        if len(cells) > at + 1 and not any(map(dialect.is_value, cells)):
            headers[""] = cells
    for line in lines:
        cells = dialect.cells(without_mark(line)) if dialect.is_comment(line) and line.strip() else []
        if len(cells) > at + 1 and cells[at] in words:
            headers[cells[at]] = cells
    return headers
