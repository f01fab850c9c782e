"""The magnetometer's rows of a log in which the rows of several sensors alternate."""

from __future__ import annotations

from collections import Counter

import pyarrow as pa
import pyarrow.compute as pc

from recordings.column_words import RAW, ColumnName
from recordings.columns import group_of
from scenarios.errors import InputError

MOST_WORDS = 30
"""A column with more different words names no sensors."""
SENSOR = {"mag", "magn", "magnetic", "magnetometer", "magneticfield", "compass", "uncalmag"}


def magnetometer_rows(table: pa.Table, stream: str | None) -> tuple[pa.Table, tuple[str, ...]]:
    """Return the rows that a word marks as the magnetometer's, and a note; the whole table where no word does.

    stream : the word, by default one that means a magnetometer; of two the raw one's.
    Raises InputError for a word that no column holds.
    """
    seen: list[str] = []
    for name in table.column_names:
        column = table.column(name)
        if group_of(name) != "channel" or not (pa.types.is_string(column.type) or pa.types.is_dictionary(column.type)):
            continue
        counts = Counter(column.to_pylist()[: 1 << 20])
        words = [word for word in counts if word]
        if not 1 < len(words) <= MOST_WORDS:
            continue
        seen += words
        word = _chosen(words, stream)
        if word is not None:
            rows = table.filter(pc.equal(column.cast(pa.string()), word)).drop_columns(name)
            note = f"{rows.num_rows} of {table.num_rows} rows are the magnetometer's ({name} = {word})"
            return rows, (f"{note}, the others were skipped",)
    if stream is not None:
        listed = ", ".join(seen) or "no column of words"
        raise InputError(f"no row is marked {stream!r}; there are {listed}", where="--stream", do="choose among them")
    return table, ()


def _chosen(words: list[str], stream: str | None) -> str | None:
    if stream is not None:
        return next((word for word in words if word.lower() == stream.lower()), None)
    parts = {word: set(ColumnName(word).words) | {word.lower()} for word in words}
    found = [word for word in words if parts[word] & SENSOR]
    return min(found, key=lambda word: not parts[word] & RAW) if found else None
