"""The lines below a text table's header as typed columns, and notes on every line and cell that was left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from recordings.readers.base import FileContents, Wanted
from recordings.readers.text.cells import TypedColumns, comments_within, headers_within, typed
from recordings.readers.text.dialect import Dialect
from recordings.readers.text.encoding import EncodedText
from recordings.readers.text.layout import TableLayout
from recordings.readers.text.rows import SkippedLines, complete_lines, line_of, parsed
from scenarios.errors import InputError

Rows = NDArray[np.int64]
CUT = "the last line is cut off and was skipped"


@dataclass(frozen=True, eq=False)
class TableBody:
    """The lines of a text table from the first row on.

    Parameters
    ----------
    path : the file, for messages.
    data : the lines, in UTF-8.
    layout, dialect : how they become columns.
    numbers : of the lines in the file, where they do not follow each other there.
    """

    path: Path
    data: memoryview
    layout: TableLayout
    dialect: Dialect
    numbers: Rows | None = None

    def contents(self, wanted: Wanted, text: EncodedText) -> FileContents:
        """Return the wanted columns, with notes; InputError where more lines are left out than read."""
        names = self.layout.names
        data = complete_lines(self.data, self.dialect, len(names))
        raw, skipped = parsed(data, self.dialect, len(names), self._which(wanted))
        self._check(raw.num_rows, skipped)
        columns = {names[int(k)]: _whole(raw.column(k)) for k in raw.column_names}
        again = headers_within(columns)
        rows = np.flatnonzero(~(again | comments_within(columns)))
        cells = typed(_taken(columns, rows, raw.num_rows), self.dialect.decimal)
        left_out = {
            "of fewer cells": skipped.fewer,
            "of more cells": skipped.more,
            "with the header again": skipped.numbers_of_rows(np.flatnonzero(again)).tolist(),
            "with a cell that is no number": skipped.numbers_of_rows(rows[cells.wrong]).tolist(),
        }
        lines = [self._told(numbers, which) for which, numbers in left_out.items() if numbers]
        cut = [CUT] if len(data) < len(self.data) else []
        notes = (*text.notes, *self._preamble(), *lines, *cut, *cells.notes)
        return FileContents({"": self._table(cells, len(rows))}, notes)

    def _which(self, wanted: Wanted) -> list[int]:
        return [k for k, name in enumerate(self.layout.names) if name and wanted(name)]

    def _check(self, rows: int, skipped: SkippedLines) -> None:
        odd = sorted(skipped.fewer + skipped.more)
        if len(odd) > rows:
            what = f"{len(odd)} of {len(odd) + rows} lines have other than {len(self.layout.names)} cells"
            do = "give a table whose rows have equally many cells"
            raise InputError(f"{what}, the first is line {self._line(odd[0])}", where=str(self.path), do=do)

    def _preamble(self) -> list[str]:
        count = self.layout.preamble
        lines = "1 line of text above the rows was" if count == 1 else f"{count} lines of text above the rows were"
        return [f"{lines} not read"] if count else []

    def _told(self, numbers: Sequence[int], which: str) -> str:
        """Return the note on rows that were skipped."""
        line = self._line(numbers[0])
        if len(numbers) == 1:
            return f"1 row {which} was skipped, in line {line}"
        return f"{len(numbers)} rows {which} were skipped, the first in line {line}"

    def _line(self, number: int) -> int:
        line = line_of(self.data, number)
        return self.layout.first + 1 + line if self.numbers is None else int(self.numbers[line])

    def _table(self, cells: TypedColumns, rows: int) -> pa.Table:
        units = dict(zip(self.layout.names, self.layout.units, strict=True))
        columns = _taken(cells.columns, np.flatnonzero(~cells.wrong), rows)
        units |= cells.units
        fields = [
            pa.field(name, column.type, metadata={"unit": units[name]} if units[name] else None)
            for name, column in columns.items()
        ]
        return pa.table(list(columns.values()), schema=pa.schema(fields))


def _whole(column: pa.ChunkedArray) -> pa.ChunkedArray | pa.Array:
    """Return text and times in one piece, and numbers without infinity and NaN."""
    kind = column.type
    if pa.types.is_floating(kind):
        finite = pc.is_finite(column)
        return column if pc.all(finite).as_py() is not False else pc.if_else(finite, column, None)
    return column.combine_chunks() if pa.types.is_string(kind) or pa.types.is_temporal(kind) else column


def _taken(columns: Mapping[str, pa.Array], rows: Rows, of: int) -> dict[str, pa.Array]:
    """Return the rows of columns; the columns themselves where all rows are meant."""
    return dict(columns) if len(rows) == of else {name: column.take(pa.array(rows)) for name, column in columns.items()}
