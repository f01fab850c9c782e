"""Where the rows of a text table begin, and what its columns are called."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from recordings.readers.text.dialect import BLANKS, CANDIDATES, Dialect
from recordings.readers.text.words import is_empty_mark, is_unit, without_mark

MOST_LINES = 300
"""Lines among which the first row is looked for; the whole head where they hold none."""
MOST_HEADER_LINES = 4
"""Names, units, and what data loggers add below."""
OPTIONAL = ("", "comment", "comments", "remark", "remarks", "note", "notes")
"""A last column's name whose cells and delimiters most rows lack."""
Cells = list[str]


class UnclearHeader(Exception):
    """A line above the rows that looks like their header but has another number of cells."""


@dataclass(frozen=True)
class TableLayout:
    """The columns and the first row of a text table.

    Parameters
    ----------
    names : of the columns, one a cell; empty for a column without name and values.
    units : one a column, empty where the text tells none.
    first : the line of the first row, counted from 0.
    preamble : lines above the rows that are neither header nor comment.
    rows : rows in the lines that were looked at.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    first: int
    preamble: int = 0
    rows: int = 0


def layout_of(lines: Sequence[str], dialect: Dialect) -> TableLayout | None:
    """Return the layout of a table in the first lines of a file; None where no line holds numbers.

    Raises UnclearHeader.
    """
    few = _layout_in(lines[:MOST_LINES], dialect)
    return few if few is not None or len(lines) <= MOST_LINES else _layout_in(lines, dialect)


def _layout_in(lines: Sequence[str], dialect: Dialect) -> TableLayout | None:
    split = {i: dialect.cells(line) for i, line in enumerate(lines) if not dialect.is_comment(line)}
    width = _width(split, dialect)
    if not width:
        return _header_alone(split)
    wide = {i: cells for i, cells in split.items() if len(cells) == width}
    numeric = _numeric(list(wide.values()), width, dialect)
    first = next((i for i, cells in wide.items() if _is_row(cells, numeric, dialect)), None)
    if first is None:
        return None
    rows = [cells for i, cells in wide.items() if i >= first]
    header, units = _header(lines[:first], rows, dialect)
    preamble = len([i for i in split if i < first]) - any(header) - any(units)
    return TableLayout(_with_numbers(header, rows), units, first, max(preamble, 0), len(rows))


def _with_numbers(header: Sequence[str], rows: Sequence[Cells]) -> tuple[str, ...]:
    """Return the names, `column_1` and so on for columns without a name that hold values."""
    given = [name or (f"column_{k + 1}" if _has_values(rows, k) else "") for k, name in enumerate(header)]
    return tuple(given)


def _width(split: dict[int, Cells], dialect: Dialect) -> int:
    """Return the number of cells in most rows, weighted by their numbers.

    Lines that begin with a word count only where there are no others.
    """
    weights: tuple[Counter[int], Counter[int]] = (Counter(), Counter())
    for cells in split.values():
        values = sum(map(dialect.is_value, cells))
        tagged = not (dialect.is_value(cells[0]) or is_empty_mark(cells[0]))
        weights[tagged][len(cells)] += values
    for weight in weights:
        if weight and max(weight.values()) > 0:
            return weight.most_common(1)[0][0]
    return 0


def _numeric(rows: Sequence[Cells], width: int, dialect: Dialect) -> list[int]:
    """Return the columns that hold numbers or times, or nothing, in most rows, and a value in some."""
    values = [sum(dialect.is_value(cells[k]) for cells in rows) for k in range(width)]
    empty = [sum(is_empty_mark(cells[k]) for cells in rows) for k in range(width)]
    return [k for k in range(width) if values[k] and 2 * (values[k] + empty[k]) >= len(rows)]


def _is_row(cells: Cells, numeric: Sequence[int], dialect: Dialect) -> bool:
    """Return whether at least half of the numeric columns hold values or nothing, and one a value."""
    values = [dialect.is_value(cells[k]) for k in numeric]
    fitting = sum(value or is_empty_mark(cells[k]) for k, value in zip(numeric, values, strict=True))
    return any(values) and 2 * fitting >= len(numeric)


def _has_values(rows: Sequence[Cells], column: int) -> bool:
    return any(cells[column] for cells in rows)


def _header(above: Sequence[str], rows: Sequence[Cells], dialect: Dialect) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the lines above the rows, the nearest first: plain lines, else comments."""
    width = len(rows[0])
    plain = [line for line in above if not dialect.is_comment(line) and not _holds_values(line, dialect)]
    comments = [without_mark(line) for line in above if dialect.is_comment(line) and line.strip()]
    for lines in (plain, comments):
        found = _names_and_units(lines[-MOST_HEADER_LINES:], rows, dialect)
        if found:
            return found
    if plain and _resembles(dialect.cells(plain[-1]), width, dialect):
        raise UnclearHeader(f"the header names {len(dialect.cells(plain[-1]))} columns, the rows have {width} cells")
    return ("",) * width, ("",) * width


def _names_and_units(
    lines: Sequence[str], rows: Sequence[Cells], dialect: Dialect
) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Return the names of the lowest line that fits the rows, or of a line above whose next line holds units."""
    fitting: list[Cells] = []
    for line in reversed(lines):
        cells = _fitted(line, rows, dialect)
        if cells is None:
            break
        fitting.insert(0, cells)
    if not fitting:
        return None
    width = len(rows[0])
    for names, units in pairwise(fitting):
        if _are_units(units):
            return tuple(names), tuple(unit.strip("[]()") for unit in units)
    return tuple(fitting[-1]), ("",) * width


def _fitted(line: str, rows: Sequence[Cells], dialect: Dialect) -> Cells | None:
    """Return the words of a line as the names of the rows' columns; None where they are numbers, or another count.

    A header may lack the delimiter at the rows' ends, may separate its names otherwise than the rows their cells, and
    may hold names of several words between wider blanks.
    """
    wider = [re.split(r"\s{2,}|\t", line.strip())] if dialect.delimiter == BLANKS else []
    others = [other.cells(line) for other in CANDIDATES if other.decimal == "."]
    for cells in (dialect.cells(line), *others, *wider):
        whole = _of_width(cells, rows)
        if whole and any(whole) and not any(dialect.is_value(cell) and cell != "1" for cell in whole):
            return whole
    return None


def _of_width(cells: Cells, rows: Sequence[Cells]) -> Cells | None:
    """Return as many cells as the rows have, where they differ by an empty last cell or one for remarks at most."""
    width = len(rows[0])
    if len(cells) == width - 1 and not _has_values(rows, width - 1):
        return [*cells, ""]
    cells = cells[:-1] if len(cells) == width + 1 and cells[-1].lower() in OPTIONAL else cells
    return cells if len(cells) == width else None


def _holds_values(line: str, dialect: Dialect) -> bool:
    """Return whether at least half of a line's cells are values, as in a row of another length."""
    cells = dialect.cells(line)
    return 2 * sum(map(dialect.is_value, cells)) >= len(cells)


def _are_units(cells: Cells) -> bool:
    given = [cell for cell in cells if cell]
    return bool(given) and 2 * sum(map(is_unit, given)) > len(given)


def _resembles(cells: Cells, width: int, dialect: Dialect) -> bool:
    """Return whether the cells are words, three or more, and a few more or fewer than the rows have."""
    words = not any(dialect.is_value(cell) for cell in cells)
    return words and len(cells) >= 3 and abs(len(cells) - width) <= 2


def _header_alone(split: dict[int, Cells]) -> TableLayout | None:
    """Return the layout of a file that holds nothing but a header."""
    if len(split) != 1:
        return None
    ((line, cells),) = split.items()
    return TableLayout(tuple(cells), ("",) * len(cells), line + 1) if len(cells) > 1 else None
