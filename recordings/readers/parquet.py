"""Parquet files of any origin."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from recordings.log_facts import FACTS, LOG_KEY
from recordings.readers.base import FileContents, FileFormat, Wanted, file_head, stripped_names
from recordings.readers.damage import check_expansion
from recordings.url_path import Place, UrlPath, arrow_source
from scenarios.errors import InputError
from scenarios.files import validated

MARK = b"PAR1"
"""The first bytes of every Parquet file."""


def is_parquet(path: Path) -> bool:
    """Whether a file begins as Parquet does; InputError where the file cannot be opened."""
    return file_head(path).startswith(MARK)


@contextmanager
def parquet_errors_about(path: Path | UrlPath) -> Iterator[None]:
    """Turn Arrow's errors about a damaged or missing Parquet file into an InputError about `path`."""
    try:
        yield
    except FileNotFoundError as error:
        raise InputError("no such file", where=str(path), do="check the path") from error
    except pa.ArrowMemoryError as error:
        raise InputError("takes more memory than there is", where=str(path), do="give a part of the log") from error
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        do = "copy or convert it again; a file that was cut off while being written cannot be read"
        raise InputError("is cut off or damaged Parquet", where=str(path), do=do) from error


def verified_table(path: Place, columns: Sequence[str] | None = None) -> pa.Table:
    """Return some or all columns of a Parquet file that magbench wrote, each page compared with its checksum.

    Raises InputError for a missing or damaged file, a missing or repeated column, and content out of proportion.
    """
    with (
        parquet_errors_about(path),
        arrow_source(path) as source,
        pq.ParquetFile(source, page_checksum_verification=True) as file,
    ):
        names = file.schema_arrow.names
        wrong = next((name for name in (*names, *(columns or ())) if names.count(name) != 1), None)
        if wrong is not None:
            times = "twice" if wrong in names else "missing"
            raise InputError(f"column {wrong} is {times}", where=str(path), do="give what magbench wrote")
        check_expansion(path, table_bytes(file.metadata, frozenset(names if columns is None else columns)))
        table = file.read(columns=None if columns is None else list(columns))
        table.validate(full=True)
    return table


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    with parquet_errors_about(path), pq.ParquetFile(path) as file:
        names = file.schema_arrow.names
        stripped = dict(zip(names, stripped_names(path, names), strict=True))
        chosen = [name for name in names if wanted(stripped[name])]
        check_expansion(path, table_bytes(file.metadata, frozenset(chosen)))
        kept = (file.metadata.metadata or {}).get(LOG_KEY.encode())
        texts = text_columns(file.schema_arrow, chosen)
    how = {"read_dictionary": list(texts), "page_checksum_verification": True}
    with parquet_errors_about(path), pq.ParquetFile(path, **how) as file:
        table = with_plain_texts(path, file.read(columns=chosen), texts)
        table.validate(full=True)  # cells that contradict their column's type would crash Arrow later
    table = table.rename_columns([stripped[name] for name in table.column_names])
    return FileContents({"": table}) if kept is None else _of_log(path, table, kept)


def _of_log(path: Path, table: pa.Table, kept: bytes) -> FileContents:
    """Return the columns of a vehicle's log with what the log told of itself; InputError for damaged metadata."""
    do = "read the vehicle's log again with `magbench read`"
    facts = validated(FACTS, kept, f"{path}: metadata {LOG_KEY!r}", do)
    applied = {} if facts.applied is None else {facts.magnetometer: facts.applied.applied()}
    place = None if facts.place is None else tuple(facts.place)
    return FileContents(
        {facts.magnetometer: table},
        frame=facts.frame,
        unit=facts.unit,
        place=place,
        date=facts.date,
        applied=applied,
    )


def table_bytes(metadata: pq.FileMetaData, names: frozenset[str]) -> int:
    """Return the bytes of columns in memory, eight a value, or those that the file states where more.

    A column whose values repeat takes next to nothing in the file.
    """
    total = 0
    for group in map(metadata.row_group, range(metadata.num_row_groups)):
        for part in map(group.column, range(group.num_columns)):
            if part.path_in_schema in names or part.path_in_schema.partition(".")[0] in names:
                total += max(8 * group.num_rows, 8 * part.num_values, part.total_uncompressed_size)
    return total


def text_columns(schema: pa.Schema, names: Sequence[str]) -> dict[str, pa.DataType]:
    """Return the columns of text with their types."""
    return {name: kind for name in names if _is_text(kind := schema.field(name).type)}


def with_plain_texts(path: Path, table: pa.Table, texts: Mapping[str, pa.DataType]) -> pa.Table:
    """Return a table whose texts were read as dictionaries with plain texts; InputError for longer texts than are read.

    A text of a megabyte that every row repeats takes a megabyte in the file.
    """
    total = 0
    for name, kind in texts.items():
        column = table.column(name)
        if pa.types.is_dictionary(column.type):
            total += sum(map(_letters, column.chunks))
            check_expansion(path, total)
            table = table.set_column(table.schema.get_field_index(name), name, column.cast(kind))
    return table


def _letters(chunk: pa.DictionaryArray) -> int:
    """Return the bytes of a chunk's texts, written out."""
    return pc.sum(pc.binary_length(chunk.dictionary).take(chunk.indices)).as_py() or 0


def _is_text(kind: pa.DataType) -> bool:
    return any(test(kind) for test in (pa.types.is_string, pa.types.is_large_string, pa.types.is_binary))


PARQUET = FileFormat(
    name="Parquet",
    suffixes=(".parquet",),
    summary="a Parquet file",
    remark="the dataset's columns, or names as in text tables",
    recognises=lambda path, head: head.startswith(MARK),
    read=_read,
)
