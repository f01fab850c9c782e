"""Print-outs of names and values: `X: 12.3 Y: 4.5 Z: -6.7 uT`, `mx=1.2, my=3.4, mz=5.6`, a value a line, JSON lines."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from recordings.readers.base import FileContents
from recordings.readers.text.cells import typed
from recordings.readers.text.encoding import EncodedText
from recordings.readers.text.lines import ChosenLines, lines_of
from recordings.readers.text.sensors import AXES, kind_of
from recordings.readers.text.words import NUMBER, TIME, is_unit
from scenarios.arrays import Array

LEAST_SHARE = 0.5
"""Share of the lines that are prints of names and values, in a file of such lines."""
LONGEST = 1000
"""Characters of a line that are looked at: the search for names takes their square."""
_VALUE = rf"(?:{TIME}|{NUMBER}|[Nn][Aa][Nn])"
_NAME = r"[A-Za-z][\w./]*(?: [\w./]+)*(?: ?[(\[][^)\]]*[)\]])?"
_UNIT = r"(?P<unit>[^\s,;|:={}\d]+)(?=[\s,;|}]|$)(?!\s*[:=])"
_NAMED = re.compile(rf'"?(?P<name>{_NAME})"?\s*[:=]\s*"?(?P<value>{_VALUE})(?![\w:])(?:\s*{_UNIT})?')
_TIME = re.compile(TIME)
_LOOSE = re.compile(rf"(?<![\w.^]){NUMBER}(?![\w.])")


@dataclass(frozen=True)
class PrintForm:
    """The form of a line of names and values.

    Parameters
    ----------
    names : in the order of the line.
    gaps : the text before each name, which may tell the sensor.
    units : one a name, empty where the line tells none.
    """

    names: tuple[str, ...]
    gaps: tuple[str, ...]
    units: tuple[str, ...]

    @property
    def pattern(self) -> str:
        """The regular expression of the form, with a group a value."""
        lead = re.sub(r"\d+", r"\\d+", re.escape(self.gaps[0]))
        named = [rf'"?{re.escape(name)}"?\s*[:=]\s*"?(?P<v{k}>{_VALUE})' for k, name in enumerate(self.names)]
        return rf"^\s*{lead}" + ".*?".join(named)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names, single letters with the sensor's word of the gap or of the name before: `Mag X: 1 Y: 2`."""
        sensor, found = "", list[str]()
        for name, gap in zip(self.names, self.gaps, strict=True):
            sensor = next((word for word in re.findall(r"[A-Za-z]\w*", gap) if kind_of(word)), sensor)
            *before, last = re.split(r"[ _.]", name)
            sensor = "_".join(before) if before and last.lower() in AXES else sensor
            new = f"{sensor}_{last}" if sensor and last.lower() in AXES else name
            found.append(f"{new}_{found.count(new) + 1}" if new in found else new)
        return tuple(found)

    @property
    def column_units(self) -> tuple[str, ...]:
        """The units, an axis without a unit having that of the sensor's next axis: `X: 1 Y: 2 Z: 3 uT`."""
        found = list(self.units)
        for k in range(len(found) - 2, -1, -1):
            sensors = [re.sub(r"[xyzXYZ]$", "", name) for name in self.columns[k : k + 2]]
            found[k] = found[k] or (found[k + 1] if sensors[0] == sensors[1] else "")
        return tuple(found)

    @property
    def has_field(self) -> bool:
        """Whether a magnetometer's values are among the columns."""
        words = [re.split(r"[_. ]", name)[0] for name in self.columns]
        return any(kind_of(word) == "mag" or word.lower() in ("mx", "bx") for word in words)


def print_form(line: str) -> PrintForm | None:
    """Return the form of a line of names and values; None for a line with more bare numbers than named values."""
    line = line[:LONGEST]
    found = list(_NAMED.finditer(line))
    if not found or 2 * len(_LOOSE.findall(_TIME.sub(" ", _NAMED.sub(" ", line)))) > len(found):
        return None
    units = (match["unit"] or "" for match in found)
    known = tuple(unit if is_unit(unit) else "" for unit in units)
    ends = [0, *(match.end() for match in found)]
    gaps = (line[end : match.start()].lstrip() for end, match in zip(ends, found, strict=False))
    return PrintForm(tuple(match["name"] for match in found), tuple(gaps), known)


def print_forms(lines: Sequence[str]) -> list[PrintForm]:
    """Return the forms that occur twice or more, in the order of the file; empty unless most lines are prints."""
    written = [line for line in lines if line.strip()]
    forms = [form for line in written if (form := print_form(line)) is not None]
    if not written or len(forms) < LEAST_SHARE * len(written):
        return []
    first: dict[str, PrintForm] = {}
    counts = Counter(form.pattern for form in forms)
    for form in forms:
        first.setdefault(form.pattern, form)
    return [form for pattern, form in first.items() if counts[pattern] > 1]


def read_prints(text: EncodedText, forms: Sequence[PrintForm]) -> FileContents:
    """Return a row for each line of the first form of a round, with the values of the other forms up to the next.

    A round begins with the first form that occurs at least half as often as the magnetometer's.
    """
    lines = lines_of(text.data)
    values = [_values(lines, form) for form in forms]
    counts = [len(rows) for rows, _ in values]
    field = next((k for k, form in enumerate(forms) if form.has_field), int(np.argmax(counts)))
    rounds = next(rows for rows, _ in values if 2 * len(rows) >= counts[field])
    tables = [_in_rounds(rounds, rows, block) for rows, block in values]
    left = len(lines.matching(r"\S")) - sum(counts)
    notes = [f"{left} of {left + sum(counts)} lines without names and values were not read"] if left else []
    return FileContents({"": _table(forms, tables)}, (*text.notes, *notes))


def _table(forms: Sequence[PrintForm], values: Sequence[Array]) -> pa.Table:
    """Return the columns of all forms, the first of a name, with their units."""
    columns: dict[str, tuple[pa.Field, pa.Array]] = {}
    for form, block in zip(forms, values, strict=True):
        for name, unit, column in zip(form.columns, form.column_units, block.T, strict=True):
            described = pa.field(name, pa.float64(), metadata={"unit": unit} if unit else None)
            columns.setdefault(name, (described, pa.array(column, from_pandas=True)))
    schema = pa.schema([described for described, _ in columns.values()])
    return pa.table([column for _, column in columns.values()], schema=schema)


def _values(lines: ChosenLines, form: PrintForm) -> tuple[Array, Array]:
    """Return the numbers of a form's lines (n,), and their values (n, k)."""
    parts = pc.extract_regex(lines.text, form.pattern)
    known = np.asarray(parts.is_valid().to_numpy(zero_copy_only=False))
    found = parts.filter(pa.array(known))
    texts = {str(k): pc.struct_field(found, [k]) for k in range(len(form.names))}
    columns = [_numbers(column) for column in typed(texts, ".").columns.values()]
    return lines.numbers[known], np.column_stack(columns)


def _numbers(column: pa.Array) -> Array:
    """Return numbers, and times in seconds."""
    if pa.types.is_timestamp(column.type):
        return np.asarray(column.cast(pa.int64()).to_numpy(zero_copy_only=False) / 1e9)
    if pa.types.is_string(column.type):
        return np.full(len(column), np.nan)
    return np.asarray(column.cast(pa.float64()).to_numpy(zero_copy_only=False))


def _in_rounds(rounds: Array, rows: Array, block: Array) -> Array:
    """Return each round's first row of a form, NaN where the round, up to the next round's line, has none: (n, k)."""
    at = np.searchsorted(rows, rounds)
    found = at < len(rows)
    found[found] &= rows[at[found]] < np.append(rounds[1:], np.inf)[found]
    values = np.full((len(rounds), block.shape[1]), np.nan)
    values[found] = block[at[found]]
    return values
