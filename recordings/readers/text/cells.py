"""Columns of text cells as numbers and times, and the rows whose cells are neither."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from recordings.readers.text.times import Mask, WrittenTimes, timestamps, unwrapped_s, written_times
from recordings.readers.text.words import EMPTY, GROUPED, NUMBER, is_unit

LEAST_REPEATS = 3
"""A wrong cell of a text that occurs so often in its column is a mark for "no value"; damage differs each time."""
_NUMBER, _GROUPED = rf"^{NUMBER}$", rf"^{GROUPED}$"
_DRESSED = rf"^[\[({{<]?\s*(?P<number>{NUMBER})\s*(?P<rest>\S*)$"
"""A number in brackets, with a unit or with a checksum."""
_CHECKSUM = re.compile(r"\*[0-9A-Fa-f]{2}")
_COMMENT = r"^(#|%|//)"
_MICROSECONDS = 1000


@dataclass(eq=False)
class TypedColumns:
    """Columns as numbers, times and words.

    Parameters
    ----------
    columns : by name, in the file's order.
    wrong : (n,) rows with a cell that is neither what its column holds nor empty.
    notes : what was joined, unwrapped and taken as empty.
    units : of columns whose cells tell them; seconds of bare clocks.
    """

    columns: dict[str, pa.Array]
    wrong: Mask
    units: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def headers_within(columns: dict[str, pa.Array]) -> Mask:
    """Return the rows (n,) that repeat the names of the columns, as after a logger's restart."""
    rows = len(next(iter(columns.values()), ()))
    if not columns or not all(pa.types.is_string(column.type) for column in columns.values()):
        return np.zeros(rows, np.bool_)
    same = [_mask(pc.equal(_trimmed(column), name)) for name, column in columns.items()]
    return np.asarray(np.all(same, axis=0), np.bool_)


def comments_within(columns: dict[str, pa.Array]) -> Mask:
    """Return the rows (n,) that are comments with as many cells as a row."""
    first = next(iter(columns.values()))
    if not pa.types.is_string(first.type):
        return np.zeros(len(first), np.bool_)
    return _mask(pc.match_substring_regex(_trimmed(first), _COMMENT))


def typed(columns: dict[str, pa.Array], decimal: str) -> TypedColumns:
    """Return columns of text as what they hold: times, numbers where at least half of the cells are numbers, words.

    The first column of dates joins the first column of clocks.
    """
    found = TypedColumns({}, np.zeros(len(next(iter(columns.values()), ())), np.bool_))
    times = {name: times for name, column in columns.items() if (times := _times_in(column)) is not None}
    for name, column in columns.items():
        if name in times:
            found.wrong |= _mask(column.is_valid()) & ~times[name].known & ~_empty(column)
            found.notes += [f"{name}: {times[name].note}"] if times[name].note else []
        elif pa.types.is_string(column.type):
            column = _numbers_or_words(name, column, decimal, found)
        found.columns[name] = column
    _place(times, found)
    return found


def _place(times: dict[str, WrittenTimes], found: TypedColumns) -> None:
    """Put times in the place of their text: a date and a clock joined, timestamps, dates, clocks in seconds."""
    dates = [name for name, written in times.items() if written.clock_ns is None]
    clocks = [name for name, written in times.items() if written.days is None]
    if dates and clocks:
        date, clock = times[dates[0]], times.pop(clocks[0])
        times[clocks[0]] = replace(clock, days=date.days, known=clock.known & date.known)
        del times[dates[0]], found.columns[dates[0]]
        found.notes.append(f"{dates[0]} and {clocks[0]} were joined to one time")
    for name, written in times.items():
        found.columns[name] = _stamped(name, written, found)


def _stamped(name: str, written: WrittenTimes, found: TypedColumns) -> pa.Array:
    if written.clock_ns is None:
        return pa.array(written.days, pa.int32(), mask=~written.known).cast(pa.date32())
    if written.days is not None:
        return timestamps(written.days, written.clock_ns, written.known, written.zoned)
    clock_s, nights = unwrapped_s(np.where(written.known, written.clock_ns / 1e9, np.nan))
    found.units[name] = "s"
    found.notes += (
        [f"{name}: the clock passes midnight {f'{nights} times' if nights > 1 else 'once'}"] if nights else []
    )
    return pa.array(clock_s, from_pandas=True)


def _times_in(column: pa.Array) -> WrittenTimes | None:
    """Return the clocks or dates of a column, whether Arrow has recognised them or left them as text."""
    if pa.types.is_time(column.type):
        known = _mask(column.is_valid())
        ticks = column.cast(pa.time64("ns")).cast(pa.int64()).fill_null(0)
        return WrittenTimes(known, None, np.asarray(ticks.to_numpy()))
    if pa.types.is_date32(column.type):
        days = column.cast(pa.int32()).fill_null(0).cast(pa.int64())
        return WrittenTimes(_mask(column.is_valid()), np.asarray(days.to_numpy()), None)
    return written_times(column) if pa.types.is_string(column.type) else None


def _numbers_or_words(name: str, column: pa.Array, decimal: str, found: TypedColumns) -> pa.Array:
    """Return text as numbers where at least half of its cells are numbers, and mark the rows of wrong cells."""
    empty = _empty(column)
    plain, unit = _bare_numbers(_trimmed(column), decimal)
    numeric = _mask(pc.match_substring_regex(plain, _NUMBER))
    wrong = ~numeric & ~empty
    if numeric.sum() < max(wrong.sum(), 1):
        return column
    marks = _marks(plain, wrong)
    for mark, count in marks.items():
        found.notes.append(f"{name}: {mark!r} in {count} cells was taken as empty")
    found.wrong |= wrong & ~_mask(pc.is_in(plain, pa.array(list(marks), pa.string())))
    found.units |= {name: unit} if unit else {}
    return pc.if_else(pa.array(numeric), plain, None).cast(pa.float64())


def _bare_numbers(cells: pa.Array, decimal: str) -> tuple[pa.Array, str]:
    """Return cells with a decimal point, without marks of thousands, brackets, checksums and units; and the unit."""
    if decimal == ",":
        swapped = pc.replace_substring(pc.replace_substring(cells, ".", "\0"), ",", ".")
        cells = pc.replace_substring(swapped, "\0", ",")
    grouped = pc.match_substring_regex(cells, _GROUPED)
    cells = pc.if_else(grouped, pc.replace_substring(cells, ",", ""), cells)
    dressed = pc.extract_regex(cells, _DRESSED)
    rests = [rest for rest in pc.unique(pc.struct_field(dressed, "rest")).to_pylist() if rest]
    units = [rest for rest in rests if is_unit(rest)]
    if len(units) > 1 or not all(rest in (*units, *"])}>") or _CHECKSUM.fullmatch(rest) for rest in rests):
        return cells, ""
    return pc.coalesce(pc.struct_field(dressed, "number"), cells), "".join(units)


def _marks(cells: pa.Array, wrong: Mask) -> dict[str, int]:
    """Return the wrong cells that occur LEAST_REPEATS times or more, and how often."""
    counts = pc.value_counts(cells.filter(pa.array(wrong)))
    return {one["values"]: one["counts"] for one in counts.to_pylist() if one["counts"] >= LEAST_REPEATS}


def _empty(column: pa.Array) -> Mask:
    if not pa.types.is_string(column.type):
        return ~_mask(column.is_valid())
    return _mask(pc.is_in(pc.utf8_lower(_trimmed(column)), pa.array(sorted(EMPTY))))


def _trimmed(column: pa.Array) -> pa.Array:
    return pc.utf8_trim(pc.fill_null(column, ""), ' \t"')


def _mask(values: pa.Array) -> NDArray[np.bool_]:
    return np.asarray(pc.fill_null(values, False).to_numpy(zero_copy_only=False), np.bool_)
