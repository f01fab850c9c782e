"""IAGA-2002: the records of magnetic observatories, one text line a minute or second."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa

from recordings.channels import SCALAR
from recordings.columns import mag_names
from recordings.decode import NotNumbersError, numbers_of
from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.navigation import median_place
from recordings.readers.text.cells import typed
from recordings.readers.text.dialect import BLANKS, Dialect
from recordings.readers.text.encoding import text_of
from recordings.readers.text.rows import parsed, table_errors_about
from scenarios.arrays import Array
from scenarios.errors import InputError

MARK = b"IAGA-2002"
"""In the first line of every file."""
MISSING = 88_888.0
"""88888.00 marks an element that is not measured, 99999.00 a missing value; no element is larger."""
_RECORDS = re.compile(rb"\nDATE +TIME +DOY ([^\r\n]*)\r?\n")
_PLACE = {
    "latitude": re.compile(rb"Geodetic Latitude\s+([-+]?\d+\.?\d*)"),
    "longitude": re.compile(rb"Geodetic Longitude\s+([-+]?\d+\.?\d*)"),
    "elevation": re.compile(rb"Elevation\s+([-+]?\d+\.?\d*)"),
}
_MINUTES = np.pi / 180 / 60
NO_BODY_FRAME = "X north, Y east and Z down of the observatory are mag_x, mag_y and mag_z: they are no body frame"


def _recognises(path: Path, head: bytes) -> bool:
    return MARK in head.split(b"\n", 1)[0]


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Return times, the field X, Y, Z in nT (n,) and the strength F; D and I are in minutes of arc in the file."""
    text = text_of(path)
    records = _RECORDS.search(text.data)
    if not records:
        do = "download the file again"
        raise InputError("is IAGA-2002 without records: there is no line DATE TIME DOY", where=str(path), do=do)
    names = ["date", "time", "DOY", *records[1].decode().replace("|", " ").split()]
    with table_errors_about(path):
        data = memoryview(text.data)[records.end() :]
        table, skipped = parsed(data, Dialect(BLANKS), len(names), range(len(names)))
    cells = typed({name: table.column(k).combine_chunks() for k, name in enumerate(names) if name != "DOY"}, ".")
    found, gaps = _values(path, {name: column.filter(pa.array(~cells.wrong)) for name, column in cells.columns.items()})
    told = {"without a value": gaps, "of another form": int(np.sum(cells.wrong)) + len(skipped.numbers)}
    notes = (*text.notes, NO_BODY_FRAME, *_losses(told))
    return FileContents({"": found}, notes, place=_place(bytes(text.data[: records.start()])))


def _losses(counts: Mapping[str, int]) -> list[str]:
    """Return a line for each kind of records that were left out."""
    told = [(which, count, "record" if count == 1 else "records") for which, count in counts.items() if count]
    return [f"{count} {records} {which} left out" for which, count, records in told]


def _place(header: bytes) -> tuple[float, ...] | None:
    """Return latitude, longitude and elevation of the observatory; None where the header does not tell them."""
    told = [_PLACE[name].search(header) for name in ("latitude", "longitude", "elevation")]
    latitude, longitude, height = (float(one[1]) if one else np.nan for one in told)
    return median_place(np.array([latitude]), np.array([longitude]), float(np.nan_to_num(height)))


def _values(path: Path, columns: Mapping[str, pa.Array]) -> tuple[pa.Table, int]:
    """Return the rows that have a whole vector, and the number of the others."""
    time = columns["time"]
    elements = {name[-1]: _element(path, column) for name, column in columns.items() if name not in ("date", "time")}
    if not pa.types.is_timestamp(time.type):
        raise InputError("holds no dates and times", where=str(path), do="download the file again")
    field_nT = field_of_elements(path, elements, _MINUTES)
    known = np.isfinite(field_nT).all(axis=1)
    found = {"time_s": time.filter(pa.array(known)), **dict(zip(mag_names(), field_nT[known].T, strict=True))}
    found |= {SCALAR: elements["F"][known]} if "F" in elements else {}
    return pa.table(found), int(np.sum(~known))


def _element(path: Path, column: pa.Array) -> Array:
    """Return an element (n,), NaN where missing."""
    try:
        values = numbers_of(pa.chunked_array([column]))
    except NotNumbersError as error:
        raise InputError(error.what, where=str(path), do="download the file again") from None
    return np.where(np.abs(values) >= MISSING, np.nan, values)


def field_of_elements(path: Path, elements: Mapping[str, Array], unit_rad: float) -> Array:
    """Return the field (n, 3), nT, from the elements X, Y, Z, or H, D, Z, or F, I, D; angles in `unit_rad`.

    X = H cos D, Y = H sin D, with H = F cos I and Z = F sin I. Raises InputError for elements of no whole vector.
    """
    if {"X", "Y", "Z"} <= elements.keys():
        return np.column_stack([elements[name] for name in "XYZ"])
    if {"F", "I", "D"} <= elements.keys():
        dip = elements["I"] * unit_rad
        elements = {**elements, "H": elements["F"] * np.cos(dip), "Z": elements["F"] * np.sin(dip)}
    if not {"H", "D", "Z"} <= elements.keys():
        what = f"gives the elements {', '.join(elements)}: no whole vector"
        raise InputError(what, where=str(path), do="give a file of X, Y, Z, or of H, D, Z")
    declination = elements["D"] * unit_rad
    return np.column_stack([elements["H"] * np.cos(declination), elements["H"] * np.sin(declination), elements["Z"]])


IAGA = FileFormat(
    name="IAGA-2002",
    suffixes=(".min", ".sec"),
    summary="an observatory's IAGA-2002 file",
    remark="observatories; also the record for `--base`",
    recognises=_recognises,
    read=_read,
)
