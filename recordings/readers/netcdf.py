"""NetCDF: a Seaglider's dives, OG1 files of gliders, and any file with a magnetometer among its variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recordings.channels import HEIGHT, LATITUDE, LONGITUDE
from recordings.readers.array_columns import columns_of, has_magnetometer, table_of
from recordings.readers.base import FileContents, FileFormat, Wanted, file_head, stripped_names
from recordings.readers.navigation import median_place
from recordings.readers.netcdf_file import (
    CLASSIC_MARKS,
    HDF_MARK,
    NetcdfFile,
    NetcdfVariable,
    middle_day,
    open_netcdf,
)
from recordings.readers.seaglider import is_seaglider, seaglider_log
from scenarios.errors import InputError

CF_UNITS = {
    "rad s-1": "rad/s",
    "degree s-1": "deg/s",
    "degrees s-1": "deg/s",
    "deg s-1": "deg/s",
    "m s-2": "m/s2",
    "degree_celsius": "degC",
    "degrees_celsius": "degC",
    "celsius": "degC",
    "counts": "count",
}
"""Units as [CF] writes them, in lower case, and as a recording's."""
PLACES = {
    LATITUDE: ("latitude", "lat", "m_gps_lat", "m_lat"),
    LONGITUDE: ("longitude", "lon", "m_gps_lon", "m_lon"),
    HEIGHT: ("depth", "glider_depth", "m_depth"),
}
"""Channels by the names that OG1 and CF give them, in lower case; the height is minus the depth."""
Columns = dict[str, NDArray[np.float64]]


def _recognises(path: Path, head: bytes) -> bool:
    return head.startswith((HDF_MARK, *CLASSIC_MARKS))


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    file = open_netcdf(path, file_head(path))
    if is_seaglider(file):
        return seaglider_log(file).contents(path, wanted, stream)
    return _table(path, file, wanted)


def _table(path: Path, file: NetcdfFile, wanted: Wanted) -> FileContents:
    """Return the variables along the magnetometer's dimension, under the file's names or their long names."""
    dimension = _magnetometer_dimension(path, file)
    along = {name: one for name, one in file.variables.items() if dimension == one.length}
    label = _labels(along)
    stripped_names(path, [label(name) for name in along])
    seconds = _clock(file, along)
    columns: Columns = {} if seconds is None else {"time_s": seconds - _first(seconds)}
    units: dict[str, str] = {}
    for name, one in along.items():
        new = columns_of(label(name), one.values) if one.since is None else {}
        columns |= new
        units |= dict.fromkeys(new, CF_UNITS.get(one.units.lower(), one.units))
    columns |= _places(along)
    others = len(file.variables) - len(along)
    return FileContents(
        {"": table_of({name: values for name, values in columns.items() if wanted(name)}, units)},
        (f"{others} variables along other dimensions than {dimension} left out",) if others else (),
        place=_place(file, along, columns),
        date=None if seconds is None else middle_day(seconds),
    )


def _clock(file: NetcdfFile, along: Mapping[str, NetcdfVariable]) -> NDArray[np.float64] | None:
    """Return the first variable of times since a date, else one as long in another group, in seconds since 1970."""
    rows = max((max(one.values.shape, default=0) for one in along.values()), default=0)
    others = {name: one for name, one in file.variables.items() if one.values.shape == (rows,)}
    clocks = (name for name, one in {**along, **others}.items() if one.since is not None and one.values.ndim == 1)
    clock = next(clocks, None)
    return file.seconds(clock) if clock else None


def _first(seconds: NDArray[np.float64]) -> float:
    return next(iter(seconds[np.isfinite(seconds)].tolist()), 0.0)


def _magnetometer_dimension(path: Path, file: NetcdfFile) -> str:
    """Return the dimension of the magnetometer's samples; InputError where none is found."""
    by_dimension: dict[str, dict[str, NetcdfVariable]] = {}
    for name, one in file.variables.items():
        if one.length:
            by_dimension.setdefault(one.length, {})[name] = one
    for dimension, along in by_dimension.items():
        label = _labels(along)
        if has_magnetometer(name for key, one in along.items() for name in columns_of(label(key), one.values)):
            return dimension
    listed = ", ".join(name for along in by_dimension.values() for name in along)
    what = f"holds no magnetometer that its names tell; its variables are {listed[:200] or 'not numbers'}"
    raise InputError(what, where=str(path), do="rename the three components, as mag_x, mag_y, mag_z")


def _labels(along: Mapping[str, NetcdfVariable]) -> Callable[[str], str]:
    """Return how variables are called: by their names where these tell a magnetometer, else by their long names."""
    plain = [name for key, one in along.items() for name in columns_of(key, one.values)]
    long = {name: one.text("long_name") or name for name, one in along.items()}
    if has_magnetometer(plain) or len(set(long.values())) < len(long):
        return lambda name: name
    return lambda name: long[name]


def _place(file: NetcdfFile, along: Mapping[str, NetcdfVariable], columns: Columns) -> tuple[float, ...] | None:
    """Return the median of the fixes, else the place of a station: single numbers, or the file's own bounds."""
    if {LATITUDE, LONGITUDE} <= columns.keys():
        heights = [one.values for name, one in along.items() if name.lower() in ("altitude", "alt", "elevation")]
        known = heights[0][np.isfinite(heights[0])] if heights else np.array([])
        return median_place(columns[LATITUDE], columns[LONGITUDE], float(np.median(known)) if len(known) else 0.0)
    return _station(file)


def _station(file: NetcdfFile) -> tuple[float, ...] | None:
    """Return the place of single numbers, else the middle of the file's own bounds; None without either."""
    single = {name.lower(): file.number(name) for name in file.variables}
    for north, east in (("latitude", "longitude"), ("lat", "lon")):
        told = single.get(north), single.get(east)
        if told[0] is not None and told[1] is not None:
            return median_place(np.array([told[0]]), np.array([told[1]]), single.get("altitude") or 0.0)
    bounds = [[_bound(file, f"geospatial_{axis}_{end}") for end in ("min", "max")] for axis in ("lat", "lon")]
    middle = np.mean(bounds, axis=1)
    return median_place(middle[:1], middle[1:])


def _bound(file: NetcdfFile, name: str) -> float:
    """Return a global attribute of one number, NaN for another."""
    try:
        return float(np.ravel(file.attributes[name])[0])
    except (KeyError, TypeError, ValueError, IndexError):
        return np.nan


def _degrees(one: NetcdfVariable) -> NDArray[np.float64]:
    """Return angles in degrees; a Slocum glider writes 4721.5 for 47 degrees and 21.5 minutes, unit lat or lon."""
    if one.units not in ("lat", "lon"):
        return one.values
    whole = np.trunc(one.values / 100)
    return np.asarray(whole + (one.values - 100 * whole) / 60)


def _places(along: Mapping[str, NetcdfVariable]) -> Columns:
    """Return latitude, longitude and height among the variables (n,)."""
    found: Columns = {}
    for channel, names in PLACES.items():
        for name, one in along.items():
            told = one.text("standard_name").lower() or name.lower()
            if one.values.ndim == 1 and (told in names or name.lower() in names) and channel not in found:
                found[channel] = -one.values if channel == HEIGHT else _degrees(one)
    return found


NETCDF = FileFormat(
    name="netCDF",
    suffixes=(".nc",),
    summary="a netCDF file",
    extra="netcdf",
    remark="Seaglider and OG1; raw counts turned to FLU",
    recognises=_recognises,
    read=_read,
)
