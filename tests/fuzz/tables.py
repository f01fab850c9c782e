"""Damage to tables: columns dropped, renamed and of other types, cells and times that were not meant, bytes."""

from __future__ import annotations

import datetime
import decimal
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from hypothesis import strategies as st

from tests.fuzz.values import ODD_TEXTS

Cells = pa.Array | pa.ChunkedArray
DAY, INSTANT = datetime.date(2026, 1, 2), datetime.datetime(2026, 1, 2, 3, 4, 5)

KINDS: dict[str, Callable[[int], Cells]] = {
    "text": lambda n: pa.array(["?"] * n),
    "numbers as text": lambda n: pa.array([f"{i}.5" for i in range(n)]),
    "long text": lambda n: pa.array(["x" * 5000] * n),
    "odd text": lambda n: pa.array([ODD_TEXTS[i % 7] for i in range(n)]),
    "bytes": lambda n: pa.array([b"\xff\xfe"] * n),
    "dates": lambda n: pa.array([DAY] * n),
    "instants": lambda n: pa.array([INSTANT + datetime.timedelta(seconds=i) for i in range(n)]),
    "far instants": lambda n: pa.array(np.arange(n) * 2**53, pa.timestamp("ms")),
    "nanoseconds": lambda n: pa.array(np.arange(n) * 7, pa.timestamp("ns", "UTC")),
    "times of day": lambda n: pa.array(np.arange(n), pa.time64("us")),
    "durations": lambda n: pa.array(np.arange(n), pa.duration("ns")),
    "decimals": lambda n: pa.array([decimal.Decimal("30000.25") + i for i in range(n)]),
    "large decimals": lambda n: pa.array([decimal.Decimal(10) ** 60] * n, pa.decimal256(76, 2)),
    "booleans": lambda n: pa.array([i % 2 == 0 for i in range(n)]),
    "halves": lambda n: pa.array(np.arange(n, dtype=np.float16)),
    "singles": lambda n: pa.array(np.linspace(-4e4, 4e4, n, dtype=np.float32)),
    "whole numbers": lambda n: pa.array(np.arange(n) * 1000),
    "large whole numbers": lambda n: pa.array(np.full(n, 2**64 - 1, np.uint64) - np.arange(n, dtype=np.uint64)),
    "nothing": lambda n: pa.nulls(n),
    "empty numbers": lambda n: pa.nulls(n, pa.float64()),
    "lists": lambda n: pa.array([[1.0, 2.0]] * n),
    "structures": lambda n: pa.array([{"x": 1.0}] * n),
    "coded text": lambda n: pa.array(["a", None] * (n // 2) + ["b"] * (n % 2)).dictionary_encode(),
    "coded numbers": lambda n: pa.array(np.arange(n) % 7 * 1e4).dictionary_encode(),
}
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, 1e300, -1e300, 1e30, 3.4e38, 5e-324, 1.0, -2.0, 45_000.0)
SCALES = (0.0, 1e-9, 1e-3, -1.0, 1e3, 1e9, 1e290)


@dataclass(frozen=True)
class Damage:
    """One thing done to a table; `how` names a function of HOW, the rest are its arguments."""

    how: str
    column: str
    row: int = 0
    value: float = 0.0
    word: str = ""

    def to(self, table: pa.Table) -> pa.Table:
        """The damaged table; the same where it has no such column, or two."""
        return HOW[self.how](table, self) if table.column_names.count(self.column) == 1 else table


def _replaced(table: pa.Table, name: str, cells: Cells) -> pa.Table:
    return table.set_column(table.column_names.index(name), name, cells)


def _numbers(table: pa.Table, name: str) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    column = table.column(name)
    return np.array(column.to_numpy(), np.float64) if pa.types.is_float64(column.type) else None


def _cells(table: pa.Table, one: Damage) -> pa.Table:
    """A few cells, or from a row on all of them, have another value."""
    values = _numbers(table, one.column)
    if values is None or not len(values):
        return table
    start = one.row % len(values)
    values[start : start + 1 + (one.row // 7) % len(values)] = one.value
    return _replaced(table, one.column, pa.array(values))


def _emptied(table: pa.Table, one: Damage) -> pa.Table:
    values = _numbers(table, one.column)
    if values is None:
        return table
    return _replaced(table, one.column, pa.array(values, mask=np.arange(len(values)) % (1 + one.row % 9) != 0))


def _scaled(table: pa.Table, one: Damage) -> pa.Table:
    values = _numbers(table, one.column)
    if values is None:
        return table
    with np.errstate(all="ignore"):
        return _replaced(table, one.column, pa.array(values * one.value))


def _copied(table: pa.Table, one: Damage) -> pa.Table:
    return _replaced(table, one.column, table.column(one.row % table.num_columns))


HOW: dict[str, Callable[[pa.Table, Damage], pa.Table]] = {
    "drop": lambda table, one: table.drop_columns([one.column]),
    "rename": lambda table, one: table.rename_columns([one.word if n == one.column else n for n in table.column_names]),
    "retype": lambda table, one: _replaced(table, one.column, KINDS[one.word](table.num_rows)),
    "cells": _cells,
    "empty": _emptied,
    "scale": _scaled,
    "copy": _copied,
    "cut": lambda table, one: table.slice(0, one.row % (table.num_rows + 1)),
    "repeat rows": lambda table, one: pa.concat_tables([table, table.slice(0, one.row)]),
    "append twice": lambda table, one: table.append_column(one.column, table.column(one.column)),
}
"""Everything that is done to a table."""


@st.composite
def damages(draw: st.DrawFn, names: list[str]) -> tuple[Damage, ...]:
    """One to three things done to a table with these columns, mostly to those that matter."""
    core = [name for name in names if name.startswith(("time", "mag", "att", "gyro"))]
    column = st.sampled_from([*core, *core, *names])

    def one() -> Damage:
        how = draw(st.sampled_from([*HOW, "retype", "cells", "cells", "scale"]))
        word = draw(st.sampled_from(list(KINDS) if how == "retype" else [*names, *ODD_TEXTS]))
        word = word if how == "retype" else word.encode("utf-8", "replace").decode()
        value = draw(st.sampled_from(SCALES if how == "scale" else NUMBERS))
        return Damage(how, draw(column), draw(st.integers(0, 200)), value, word)

    return tuple(one() for _ in range(draw(st.integers(1, 3))))


@dataclass(frozen=True)
class Bytes:
    """A file's bytes: cut at a place, or some of them overwritten; places as parts of a thousand, from its end."""

    at: int
    new: bytes
    cut: bool

    def to(self, content: bytes) -> bytes:
        """The damaged content."""
        place = len(content) - 1 - self.at * (len(content) - 1) // 1000
        if self.cut:
            return content[:place]
        return content[:place] + self.new + content[place + len(self.new) :]


broken_bytes = st.builds(
    Bytes, st.integers(0, 1000), st.binary(min_size=1, max_size=6), st.integers(0, 5).map(lambda i: not i)
)
