"""Lines of several sensors as one table: the magnetometer's lines, and the other sensors' values at their times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import numpy as np
import pyarrow as pa

from recordings.readers.base import FileContents
from recordings.readers.navigation import median_place
from recordings.readers.text.body import TableBody
from recordings.readers.text.dialect import Dialect
from recordings.readers.text.encoding import EncodedText
from recordings.readers.text.exports import as_exported
from recordings.readers.text.layout import TableLayout
from recordings.readers.text.lines import ChosenLines, lines_of
from recordings.readers.text.sensors import AXES, COUNTS, is_nine, is_sentence, kind_of, letters, names_of, prefix
from recordings.readers.text.tags import COLON, TaggedLines
from recordings.readers.text.words import plain_number
from recordings.streams import Stream, merge
from scenarios.arrays import Array
from scenarios.errors import InputError

FIXES = "fix"
"""The word of lines of satellites' fixes."""
LEAST_RISING = 0.99
"""Share of steps that do not go back in a column of time."""


@dataclass(frozen=True, eq=False)
class SensorLog:
    """A text log of lines that name their sensors.

    Parameters
    ----------
    path, text : the file.
    tagged, dialect : how its lines are told apart and cut into cells.
    """

    path: Path
    text: EncodedText
    tagged: TaggedLines
    dialect: Dialect

    def contents(self, stream: str | None) -> FileContents:
        """Return the magnetometer's lines, or those of the word `stream`, with accelerometer and gyro at their times.

        Raises InputError where no word is known as a magnetometer's, or `stream` is none of the words.
        """
        word = self._word(stream)
        lines = lines_of(self.text.data)
        main = self._table(word, lines)
        others = {kind: self._best(kind, word) for kind in ("accel", "gyro")}
        streams = {other: self._table(other, lines).table for other in others.values() if other}
        columns, joined = _joined(main.table, streams)
        left = [other for other in self.tagged.widths if other not in (word, *joined)]
        notes = [f"the magnetometer's lines are those of {word}"] if len(self.tagged.widths) > 1 else []
        notes += [f"the lines of {', '.join(joined)} were brought to their times"] if joined else []
        notes += [f"the lines of {', '.join(left)} were not read"] if left else []
        found = FileContents({"": columns}, (*self.text.notes, *notes, *main.notes), place=self._place(lines))
        return as_exported(found, b"") if is_sentence(word, self.tagged.widths[word] - 1) else found

    def _place(self, lines: ChosenLines) -> tuple[float, ...] | None:
        """Return the median of the fixes in GnssLogger's lines of this name; None without any."""
        word = next((word for word in self.tagged.widths if letters(word) == FIXES), None)
        if word is None or not self.tagged.names(word):
            return None
        table = self._table(word, lines).table
        found = [_numbers_in(table, start) for start in ("latitude", "longitude", "altitude")]
        known = [values for values in found if values is not None]
        if len(known) < len(found) or not len(known[0]):
            return None
        latitude, longitude, altitude = known
        return median_place(latitude, longitude, float(np.nan_to_num(np.median(altitude))))

    def _word(self, stream: str | None) -> str:
        words = self.tagged.widths
        found = {letters(word): word for word in words}.get(letters(stream)) if stream else self.tagged.magnetometer
        if found:
            return found
        listed, do = ", ".join(words), "name the magnetometer's with --stream WORD"
        what = f"holds lines of {listed}, and {f'none of {stream}' if stream else 'no known magnetometer among them'}"
        raise InputError(what, where=str(self.path), do=do)

    def _best(self, kind: str, main: str) -> str | None:
        """Return the word of another sensor, uncalibrated values first."""
        found = [word for word in self.tagged.widths if kind_of(word) == kind and word != main]
        return min(found, key=lambda word: "uncal" not in letters(word), default=None)

    def _table(self, word: str, lines: ChosenLines) -> FileContents:
        """Return the columns of a word's lines."""
        chosen = lines.matching(self.tagged.pattern(word, self.dialect))
        if any(":" in str(line) for line in chosen.text[:1]):
            chosen = chosen.replaced(COLON, rf"\1{self.dialect.delimiter}")
        at, width = self.tagged.at, self.tagged.widths[word]
        given = self.tagged.names(word)
        timed = width > len(AXES) + 1 and self._rises(word)
        names = names_of(word, given, width - 1, timed, self._run(word) - timed)
        layout = TableLayout((*names[:at], "", *names[at:]), ("",) * width, 0)
        ended = self.text.ended or len(lines) not in chosen.numbers[-1:]
        body = TableBody(self.path, chosen.joined(ended), layout, self.dialect, chosen.numbers)
        found = body.contents(lambda name: True, EncodedText(b""))
        table = _in_units(found.table) if is_nine(word, width - 1) else _with_unit_of_all(word, found.table)
        return FileContents({"": table}, found.notes)

    def _run(self, word: str) -> int:
        """Return how many values of a word's lines, in the median, come before the first that holds no digit."""
        values = [[cell for k, cell in enumerate(cells) if k != self.tagged.at] for cells in self.tagged.rows[word]]
        runs = [len(list(takewhile(lambda cell: any(map(str.isdigit, cell)), cells))) for cells in values]
        return sorted(runs)[len(runs) // 2]

    def _rises(self, word: str) -> bool:
        """Return whether the first value of a word's first lines is a clock, or never goes back and does not stay."""
        first = [cells[1 if self.tagged.at == 0 else 0] for cells in self.tagged.rows[word]]
        found = (plain_number(cell, self.dialect.decimal) for cell in first)
        numbers = [number for number in found if number is not None]
        return not numbers or (bool(np.all(np.diff(numbers) >= 0)) and numbers[-1] > numbers[0])


def _numbers_in(table: pa.Table, start: str) -> Array | None:
    """Return the column of numbers whose name begins with a word, None without one."""
    found = (name for name in table.column_names if name.lower().startswith(start))
    name = next((name for name in found if _is_number(table.column(name).type)), None)
    return None if name is None else _ticks(table.column(name))


def _in_units(table: pa.Table) -> pa.Table:
    """Return MotionCal's counts in units."""
    for name in table.column_names if any(name.startswith("raw_") for name in table.column_names) else []:
        count, unit = COUNTS[name.split("_")[1]]
        values = pa.array(count * np.asarray(table.column(name).cast(pa.float64()).to_numpy()), from_pandas=True)
        field = pa.field(name, pa.float64(), metadata={"unit": unit})
        table = table.set_column(table.column_names.index(name), field, values)
    return table


def _with_unit_of_all(word: str, table: pa.Table) -> pa.Table:
    """Return the axes of a sensor with the unit that stands behind the last: `M: 0.1, 0.2, 0.3 gauss`."""
    fields = {field.name: field for field in table.schema}
    own = [fields[name] for axis in AXES if (name := f"{prefix(word)}_{axis}") in fields]
    told = next((field.metadata for field in own if field.metadata), None)
    fields |= {field.name: field.with_metadata(told) for field in own if told}
    return table.cast(pa.schema(list(fields.values())))


def _joined(main: pa.Table, streams: Mapping[str, pa.Table]) -> tuple[pa.Table, list[str]]:
    """Return the main columns and those of the streams at its times, and the words of the streams that have times."""
    time = next((name for name in main.column_names if _is_time(main.column(name))), None)
    if time is None:
        return main, []
    at = _ticks(main.column(time))
    timed = {word: table for word, table in streams.items() if time in table.column_names}
    if not timed or not np.all(np.diff(at) > 0):
        return main, []
    merged = merge(Stream(at, {}), {word: _stream(word, table, time, main) for word, table in timed.items()})
    for name, values in merged.columns.items():
        main = main if name == "time_s" else main.append_column(name, pa.array(values, from_pandas=True))
    return main, list(timed)


def _stream(word: str, table: pa.Table, time: str, main: pa.Table) -> Stream:
    """Return the numbers of a sensor's lines, under names that the main table does not have."""
    numeric = [name for name in table.column_names if _is_number(table.column(name).type) and name != time]
    named = {f"{prefix(word)}_{name}" if name in main.column_names else name: name for name in numeric}
    columns = {new: np.asarray(table.column(old).cast(pa.float64()).to_numpy()) for new, old in named.items()}
    return Stream(
        _ticks(table.column(time)), {n: v for n, v in columns.items() if n not in (*main.column_names, "time_s")}
    )


def _is_number(kind: pa.DataType) -> bool:
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))


def _is_time(column: pa.ChunkedArray) -> bool:
    """Return whether a column never goes back, but for a few steps, and does not stay."""
    if pa.types.is_timestamp(column.type):
        return True
    if not _is_number(column.type) or len(column) < len(AXES):
        return False
    values = _ticks(column)
    return bool(np.mean(np.diff(values) >= 0) >= LEAST_RISING and values[-1] > values[0])


def _ticks(column: pa.ChunkedArray) -> Array:
    """Return numbers or times as numbers, NaN where empty."""
    numbers = column.cast(pa.int64()) if pa.types.is_timestamp(column.type) else column
    return np.asarray(numbers.cast(pa.float64()).to_numpy())
