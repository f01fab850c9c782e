"""The way of a text log from its bytes to columns: encoding, dialect, header, rows, cells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from recordings.readers.base import HEAD_BYTES, FileContents, Wanted, stripped_names
from recordings.readers.text.body import TableBody
from recordings.readers.text.brackets import unbracketed
from recordings.readers.text.dialect import Dialect, dialect_of, named_delimiter
from recordings.readers.text.encoding import EncodedText, decoded, is_text, text_of
from recordings.readers.text.exports import as_exported
from recordings.readers.text.layout import MOST_LINES, TableLayout, UnclearHeader, layout_of
from recordings.readers.text.prints import print_forms, read_prints
from recordings.readers.text.rows import table_errors_about
from recordings.readers.text.several import SensorLog
from recordings.readers.text.stamped import unstamped
from recordings.readers.text.tags import TaggedLines, tagged_lines
from scenarios.errors import InputError

CONVERT = "convert it to a text table with a header line, or to Parquet"


def read(path: Path, wanted: Wanted, stream: str | None = None) -> FileContents:
    """Return the wanted columns of a text log; InputError for a file that is no text, or holds no rows of numbers.

    stream : the word of the magnetometer's lines, where a word of each line tells its sensor.
    """
    return read_decoded(path, text_of(path), wanted, stream)


def read_decoded(path: Path, text: EncodedText, wanted: Wanted, stream: str | None = None) -> FileContents:
    """Return the wanted columns of a text log that was read already; messages call the file `path`."""
    if not is_text(b"".join(text.head())):
        raise InputError("is not a text table", where=str(path), do=CONVERT)
    quoted = b'"' in text.data
    text = unstamped(text, _lines(text)[:MOST_LINES], quoted)
    text = unbracketed(text, _lines(text)[:MOST_LINES])
    lines = _lines(text)
    dialect = dialect_of(lines, quoted)
    forms = print_forms(lines[:MOST_LINES])
    tagged = tagged_lines(lines[:MOST_LINES], dialect)
    with table_errors_about(path):
        if forms:
            return read_prints(text, forms)
        if tagged is not None and (stream or not _is_plain(tagged)):
            return SensorLog(path, text, tagged, dialect).contents(stream)
        return _read_table(path, text, lines, dialect, wanted)


def _is_plain(tagged: TaggedLines) -> bool:
    """Return whether words in the lines are a column of a table with a header, and no names of sensors."""
    return tagged.is_table or (bool(tagged.headers.get("")) and tagged.magnetometer is None)


def is_table(head: bytes) -> bool:
    """Return whether the first bytes of a file are text with rows of numbers."""
    text = decoded(head)
    if not is_text(text.data):
        return False
    lines = _lines(unbracketed(text, _lines(text)[:MOST_LINES]))
    if print_forms(lines[:MOST_LINES]):
        return True
    try:
        layout = layout_of(lines, dialect_of(lines, b'"' in head))
    except UnclearHeader:
        return True
    return layout is not None and layout.rows > 1


def _read_table(path: Path, text: EncodedText, lines: Sequence[str], dialect: Dialect, wanted: Wanted) -> FileContents:
    """Return the wanted columns of a table with one row a line."""
    layout = _layout(path, lines, dialect)
    start = sum(map(len, text.head()[: layout.first]))
    found = TableBody(path, memoryview(text.data)[start:], layout, dialect).contents(wanted, text)
    return as_exported(found, text.data[:HEAD_BYTES])


def _lines(text: EncodedText) -> list[str]:
    """Return the lines of the head, empty for the first of a spreadsheet, which names the delimiter."""
    lines = [line.decode("utf-8", "replace") for line in text.head()]
    return ["" if k == 0 and named_delimiter(line) else line for k, line in enumerate(lines)]


def _layout(path: Path, lines: Sequence[str], dialect: Dialect) -> TableLayout:
    try:
        layout = layout_of(lines, dialect)
    except UnclearHeader as error:
        do = "give the header as many names as the rows have cells"
        raise InputError(str(error), where=str(path), do=do) from None
    if layout is None:
        what = f"is not a text table: no row of numbers in the first {len(lines)} lines"
        raise InputError(what, where=str(path), do=CONVERT)
    stripped_names(path, [name for name in layout.names if name])
    return layout
