"""The file formats that recordings are read from: one file a format, and one entry in FORMATS."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from recordings.readers.ardupilot import ARDUPILOT_LOG, ARDUPILOT_TEXT
from recordings.readers.base import FileContents, FileFormat, Wanted, file_head
from recordings.readers.blackbox import BLACKBOX
from recordings.readers.iaga import IAGA
from recordings.readers.imagcdf import IMAGCDF
from recordings.readers.mat import MAT
from recordings.readers.netcdf import NETCDF
from recordings.readers.parquet import PARQUET, is_parquet, parquet_errors_about, verified_table
from recordings.readers.phone import PHONE
from recordings.readers.px4 import PX4
from recordings.readers.ros import ROS
from recordings.readers.text import TEXT
from recordings.readers.tlog import TELEMETRY_LOG
from scenarios.errors import InputError

__all__ = ["FORMATS", "FileContents", "FileFormat", "is_parquet", "load", "parquet_errors_about", "verified_table"]

FORMATS: tuple[FileFormat, ...] = (
    *(PARQUET, ARDUPILOT_LOG, ARDUPILOT_TEXT, TELEMETRY_LOG, PX4, ROS, BLACKBOX),
    *(NETCDF, IMAGCDF, MAT, PHONE, IAGA, TEXT),
)
"""Every format, in the order of recognition: by content first, by the suffix alone last."""
SPREADSHEETS = (".xls", ".xlsx", ".ods")
"""Suffixes of spreadsheets, whose tables are read as CSV alone."""


def load(path: Path, wanted: Wanted, stream: str | None = None) -> FileContents:
    """Read the wanted columns of a file, in the first format of FORMATS that recognises the file.

    stream : the word that marks the magnetometer's rows in a log of several sensors.

    Blanks around column names are removed. Raises InputError for a file that is missing, a directory, unreadable,
    empty, damaged, ragged or of no known format, and for two columns of the same name.
    """
    marked = marked_file(path)
    found = format_of(marked)
    contents = found.read(path if found.whole else marked, wanted, stream)
    tables = {
        name: table.select([column for column in table.column_names if wanted(column)])
        for name, table in contents.tables.items()
    }
    return replace(contents, tables=tables)


def format_of(path: Path) -> FileFormat:
    """Return the first format of FORMATS that recognises a file; InputError for none, see `load`."""
    head = file_head(path)
    found = next((entry for entry in FORMATS if entry.recognises(path, head)), None)
    if found is None:
        raise _unknown(path)
    return found


def marked_file(path: Path) -> Path:
    """Return the file by which a directory is a log of some format, else the path itself."""
    markers = [marker for entry in FORMATS for marker in entry.markers] if path.is_dir() else []
    marked = (file for marker in markers for file in sorted(path.glob(marker)))
    return next((file for file in marked if file.is_file()), path)


def _unknown(path: Path) -> InputError:
    """Return the error for a file of no known format: the formats, and what a file of this suffix would be."""
    if path.suffix.lower() in SPREADSHEETS:
        return InputError("is a spreadsheet", where=str(path), do="save or export it as CSV")
    names = [entry.name for entry in FORMATS]
    meant = [entry.summary for entry in FORMATS if path.suffix.lower() in entry.suffixes]
    suffixes = ", ".join(suffix for entry in FORMATS for suffix in entry.suffixes)
    what = f"is neither {', '.join(names[:-1])} nor {names[-1]}"
    return InputError(what, where=str(path), do=f"give {' or '.join([*meant, f'a log of these ({suffixes})'])}")
