"""ImagCDF: the records of magnetic observatories in NASA's Common Data Format, by cdflib."""

from __future__ import annotations

import datetime
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.channels import SCALAR
from recordings.columns import mag_names
from recordings.files import system_errors_about
from recordings.readers.base import FileContents, FileFormat, Wanted, library
from recordings.readers.cdf_records import COMPRESSED, WHOLE, DamagedCdfError, check_records
from recordings.readers.damage import (
    MOST_VALUES,
    check_expansion,
    check_values,
    library_errors_about,
    most_expanded,
)
from recordings.readers.iaga import NO_BODY_FRAME, field_of_elements
from scenarios.arrays import Array
from scenarios.errors import InputError

MARK = b"\xcd\xf3\x00\x01"
"""The first bytes of CDF 3, which alone has the times of ImagCDF."""
ELEMENT = re.compile(r"GeomagneticField([A-Z])")
TIMES = ("GeomagneticVectorTimes", "DataTimes")
SCALARS = "SFG"
"""Elements of a scalar instrument, S or G, or the strength F of the vector."""
TEMPERATURE = re.compile(r"Temperature\d*")
START = np.datetime64("2000-01-01T11:58:50.816", "ns")
"""Noon of 1 January 2000 less 69.184 s: with it TT2000 gives UTC of 2017 and later, and up to 5 s less before."""
_FORM = "CDF"


def _recognises(path: Path, head: bytes) -> bool:
    return head.startswith(MARK) and head[4:8] in (WHOLE, COMPRESSED)


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Return times, the field X, Y, Z in nT (n,), the scalar strength and temperatures where sampled with it.

    Angles are in degrees of arc; a sample that equals FILLVAL is missing.
    """
    _check(path)
    variables, place = _variables(path)
    times = next((variables[name] for name in TIMES if name in variables), None)
    if times is None or not any(map(ELEMENT.fullmatch, variables)):
        what = "is CDF without GeomagneticField variables and their times: no ImagCDF"
        raise InputError(what, where=str(path), do="give an observatory's ImagCDF file")
    columns = _columns(path, times, variables)
    known = np.isfinite(np.column_stack([columns[name] for name in mag_names()])).all(axis=1)
    gaps = int(np.sum(~known))
    lines = [f"{gaps} {'record' if gaps == 1 else 'records'} without a value left out"] if gaps else []
    table = pa.table({name: pa.array(values[known], from_pandas=True) for name, values in columns.items()})
    return FileContents({"": table}, (NO_BODY_FRAME, *lines), place=place, date=_date(times))


def _columns(path: Path, times: NDArray[np.int64], variables: Mapping[str, NDArray[Any]]) -> dict[str, Array]:
    """Return seconds since the first record, the field, and what else has a value a record of the vector's."""
    same = {name: values for name, values in variables.items() if len(values) == len(times)}
    elements = {found[1]: values for name, values in same.items() if (found := ELEMENT.fullmatch(name))}
    field_nT = field_of_elements(path, elements, np.pi / 180)
    columns = {"time_s": (times - times[:1]) / 1e9, **dict(zip(mag_names(), field_nT.T, strict=True))}
    scalar = next((elements[name] for name in SCALARS if name in elements), None)
    columns |= {} if scalar is None else {SCALAR: scalar}
    return columns | {name: values for name, values in same.items() if TEMPERATURE.fullmatch(name)}


def _date(times: NDArray[Any]) -> datetime.date | None:
    """Return the day of the middle record; None for times out of the calendar's range."""
    day = (START + np.timedelta64(int(times[len(times) // 2]), "ns")).astype("datetime64[D]") if len(times) else None
    found = day.item() if day is not None else None
    return found if isinstance(found, datetime.date) else None


def _variables(path: Path) -> tuple[dict[str, NDArray[Any]], tuple[float, ...] | None]:
    """Return every variable of one number a record, (n,), NaN where missing, times in ns; and the place."""
    reader = library(path, "cdflib", "cdf")
    with library_errors_about(path, _FORM):
        file = reader.CDF(path)
        names = [n for n in file.cdf_info().zVariables if ELEMENT.match(n) or TEMPERATURE.match(n) or n in TIMES]
        declared = sum(_size(file.varinq(name)) for name in names)
        check_values(path, declared)
        check_expansion(path, 8 * declared)
        found = {name: _values(file, name) for name in names}
        attributes = file.globalattsget()
    return {name: values for name, values in found.items() if values.ndim == 1}, _place(attributes)


def _size(inquiry: Any) -> int:
    """Return the numbers that a variable declares, in eight bytes each."""
    return (int(inquiry.Last_Rec) + 1) * int(np.prod(inquiry.Dim_Sizes or [1])) * int(inquiry.Num_Elements)


def _values(file: Any, name: str) -> NDArray[Any]:
    values = np.atleast_1d(np.asarray(file.varget(name)))
    if name in TIMES:
        return values.astype(np.int64)
    fill = np.ravel(np.asarray(file.varattsget(name).get("FILLVAL", np.nan), np.float64))
    numbers = values.astype(np.float64)
    return np.where(np.isin(numbers, fill), np.nan, numbers)


def _place(attributes: Mapping[str, Any]) -> tuple[float, ...] | None:
    """Return latitude, longitude and altitude in m of the observatory; None where not stated."""
    try:
        parts = [float(np.ravel(attributes[name])[0]) for name in ("Latitude", "Longitude", "Elevation")]
    except (KeyError, IndexError, TypeError, ValueError):
        return None
    latitude, longitude, altitude = parts
    inside = abs(latitude) <= 90 and -180 <= longitude <= 360 and np.isfinite(altitude)
    return (latitude, longitude, altitude) if inside else None


def _check(path: Path) -> None:
    """Raise InputError for a file that a library would follow for ever, or for more memory than there is."""
    with system_errors_about(path, "check the path and the permissions"):
        data = path.read_bytes()
    try:
        check_records(data, min(8 * MOST_VALUES, most_expanded(len(data))))
    except DamagedCdfError as error:
        raise InputError(f"cannot be read as CDF: {error}", where=str(path), do="download it again") from error


IMAGCDF = FileFormat(
    name="ImagCDF",
    suffixes=(".cdf",),
    summary="an observatory's ImagCDF file",
    extra="cdf",
    remark="observatories: the quiet field",
    recognises=_recognises,
    read=_read,
)
