"""A file format that recordings are read from, and what all formats share: the first bytes and the column names."""

from __future__ import annotations

import datetime
import importlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pyarrow as pa

from recordings.applied import AppliedCalibration
from recordings.files import system_errors_about
from scenarios.errors import InputError
from scenarios.files import check_regular

HEAD_BYTES = 1 << 16
"""Bytes from the start of a file by which formats are recognised."""
Wanted = Callable[[str], bool]
"""Whether a column of this name is to be read."""


@dataclass(frozen=True, eq=False)
class FileContents:
    """The columns that a reader found in a file.

    Parameters
    ----------
    tables : by the name of a magnetometer, the main magnetometer first: the columns at that magnetometer's times.
        Sensors sampled together share a table, as `mag1_x_nT`, `mag2_x_nT`, ...; a table format has one table.
        Slower or faster streams are brought to the table's times by `recordings.streams.merge`.
    notes : a line for each change that the reader made: axes turned to FLU and ENU, an autopilot's calibration undone,
        rows removed, gaps left empty.
    magnetometers : the names of all magnetometers in a log of several, those included that were not read.
    frame : the log's body frame, "flu" or "frd", where the format fixes it: the reader has turned the columns to FLU.
    unit : of magnetometer columns under a recording's names: nT, or "count" where the gain is not known.
    place : latitude and longitude in degrees and altitude in m, and date : where the log tells them.
    start_s : seconds since 1970 (UTC) at time_s = 0, where the log tells the time of day otherwise than by time_s.
    applied : by the name of a magnetometer, the calibration that the autopilot had in force.
    """

    tables: Mapping[str, pa.Table]
    notes: tuple[str, ...] = ()
    magnetometers: tuple[str, ...] = ()
    frame: str = ""
    unit: str = "nT"
    place: tuple[float, ...] | None = None
    date: datetime.date | None = None
    start_s: float | None = None
    applied: Mapping[str, AppliedCalibration] = field(default_factory=dict)

    @property
    def magnetometer(self) -> str:
        """The name of the main magnetometer."""
        return next(iter(self.tables))

    @property
    def table(self) -> pa.Table:
        """The columns of the main magnetometer."""
        return self.tables[self.magnetometer]


@dataclass(frozen=True)
class FileFormat:
    """A file format, with the functions that recognise a file by its content and read the columns.

    Parameters
    ----------
    name : the format in messages, as in "is neither Parquet nor CSV".
    suffixes : of the format's files, lower case, with the dot.
    summary : a file of the format in words, as in "give a Parquet file".
    recognises : (path, first HEAD_BYTES bytes) -> whether the file has this format.
    read : (path, wanted, stream) -> the contents; a reader may return columns that are not wanted. `stream` names the
        magnetometer among several sensors, None where nobody said; formats of one sensor ignore it. Raises InputError
        for a file that is damaged or ragged, and for two columns of the same name.
    markers : files' names, or patterns with *, by which a directory is a log of the format: `read` and `recognises`
        then get the first file that is there as their `path`, where `whole` is set `read` gets the directory.
    extra : the optional extra of the installation that the format's library comes with; "" for none.
    remark : what is undone or special, in a few words, as in the table of docs/logs.md.
    """

    name: str
    suffixes: tuple[str, ...]
    summary: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path, Wanted, str | None], FileContents]
    markers: tuple[str, ...] = ()
    whole: bool = False
    extra: str = ""
    remark: str = ""


def file_head(path: Path) -> bytes:
    """Return the first HEAD_BYTES bytes; InputError for a missing, unreadable or empty file, and for a directory."""
    if path.is_dir():
        do = "give a file, or a directory that `magbench simulate` wrote"
        raise InputError("is a directory, not a recording", where=str(path), do=do)
    with system_errors_about(path, "check the path and the permissions"):
        check_regular(path)
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    if not head:
        raise InputError("is empty", where=str(path), do="record, copy or convert it again")
    return head


def stripped_names(path: Path, names: Sequence[str]) -> list[str]:
    """Return the column names without surrounding blanks; InputError where two names become the same."""
    stripped = [name.strip() for name in names]
    twice = [name for name, count in Counter(stripped).items() if count > 1]
    if twice:
        raise InputError("there are two columns of this name", where=f"{path}: {twice[0]}", do="rename one of them")
    return stripped


def library(path: Path, module: str, extra: str) -> Any:
    """Return a library that only a format's reader imports; InputError where its optional extra is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        do = f"pip install 'magbench[{extra}]'"
        raise InputError(f"needs {module.split('.')[0]} to be read", where=str(path), do=do) from None
