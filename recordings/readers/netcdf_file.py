"""The variables of a netCDF file with their dimensions and attributes: netCDF-4 by h5py, netCDF-3 by scipy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.readers.base import library
from recordings.readers.damage import MOST_VALUES, check_expansion, check_values, library_errors_about
from recordings.readers.hdf5 import Attributes, data_sets, declared_bytes
from recordings.readers.since import Since, since_of
from scenarios.arrays import Array
from scenarios.errors import InputError

HDF_MARK = b"\x89HDF\r\n\x1a\n"
CLASSIC_MARKS = (b"CDF\x01", b"CDF\x02")
"""The first bytes of netCDF-3, classic and with 64-bit offsets."""
MOST_GROUPS = 3
"""Groups within groups that are entered; their variables have dotted names."""
FILLS = ("_FillValue", "missing_value")
"""Attributes that state the number for "no value"."""
_FORM = "netCDF"


@dataclass(frozen=True, eq=False)
class NetcdfVariable:
    """A variable of numbers: the names of its dimensions, its attributes, and its values as float64, NaN where missing.

    Scale and offset are applied: value = scale_factor x stored + add_offset.
    """

    dimensions: tuple[str, ...]
    attributes: Mapping[str, Any]
    values: NDArray[Any]

    @property
    def length(self) -> str:
        """The dimension of the samples: the longer one of two, else the first; "" for a single number."""
        along = int(np.argmax(self.values.shape)) if self.values.ndim == 2 else 0
        return self.dimensions[along] if self.dimensions else ""

    def text(self, name: str) -> str:
        """Return an attribute as text, empty where absent."""
        return as_text(self.attributes.get(name, ""))

    @property
    def units(self) -> str:
        """The units, in lower case."""
        return self.text("units").strip()

    @property
    def since(self) -> Since | None:
        """The unit and the start of times, as `seconds since 1970-01-01`; None for another quantity."""
        return since_of(self.units)


@dataclass(frozen=True, eq=False)
class NetcdfFile:
    """The variables of numbers by name, and the global attributes."""

    variables: Mapping[str, NetcdfVariable]
    attributes: Mapping[str, Any]

    def seconds(self, name: str) -> Array | None:
        """Return a variable of times (n,) in seconds since 1970; None for another variable."""
        variable = self.variables.get(name)
        since = variable.since if variable is not None else None
        return since.seconds(variable.values) if variable is not None and since is not None else None

    def number(self, name: str) -> float | None:
        """Return a variable of one number; None where absent or not finite."""
        variable = self.variables.get(name)
        if variable is None or variable.values.size != 1:
            return None
        value = float(variable.values.ravel()[0])
        return value if np.isfinite(value) else None


def as_text(value: Any) -> str:
    """Return an attribute's value as text."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def middle_day(seconds: Array) -> date | None:
    """Return the day of the median of times since 1970; None where none is finite and in the calendar."""
    finite = seconds[np.isfinite(seconds)]
    if not len(finite) or not 0 < float(np.median(finite)) < 4e9:
        return None
    return date.fromordinal(date(1970, 1, 1).toordinal() + int(np.median(finite) // 86_400))


def open_netcdf(path: Path, head: bytes) -> NetcdfFile:
    """Read the variables of numbers; InputError for a damaged file, and for more than MOST_VALUES numbers."""
    return _hdf(path) if head.startswith(HDF_MARK) else _classic(path)


def _hdf(path: Path) -> NetcdfFile:
    h5py = library(path, "h5py", "netcdf")
    with library_errors_about(path, _FORM), h5py.File(path, "r") as file:
        sets = {name: item for name, item in data_sets(h5py, file, MOST_GROUPS, str(path)) if _is_numeric(item)}
        declared = sum(map(declared_bytes, sets.values()))
        check_values(path, declared // 8)
        check_expansion(path, declared)
        attributes = Attributes(str(path))
        shapes = {name: _dimensions(name, item) for name, item in sets.items()}
        found = {name: _variable(shapes[name], attributes.of(item), item[()]) for name, item in sets.items()}
        return NetcdfFile(found, attributes.of(file))


def _is_numeric(item: Any) -> bool:
    """Return whether a data set is a variable of numbers, and no dimension without values."""
    bare = as_text(item.attrs.get("NAME", "")).startswith("This is a netCDF dimension but not")
    return item.dtype.kind in "fiu" and not bare


def _dimensions(name: str, item: Any) -> tuple[str, ...]:
    """Return the dimensions: a coordinate's own name, else the scales' names, else the length."""
    if item.is_scale and len(item.shape) == 1:
        return (name,)
    scales = [dimension[0].name.strip("/").replace("/", ".") if len(dimension) else "" for dimension in item.dims]
    return tuple(scale or f"of {size}" for scale, size in zip(scales, item.shape, strict=True))


def _classic(path: Path) -> NetcdfFile:
    from scipy.io import netcdf_file

    if path.stat().st_size > 8 * MOST_VALUES:
        raise InputError("is larger than what is read", where=str(path), do="give a part of the log")
    with library_errors_about(path, _FORM), netcdf_file(path, "r", mmap=False) as file:
        sets = {name: item for name, item in file.variables.items() if item.data.dtype.kind in "fiu"}
        check_values(path, sum(int(item.data.size) for item in sets.values()))
        found = {name: _variable(item.dimensions, dict(item._attributes), item.data) for name, item in sets.items()}
        return NetcdfFile(found, dict(file._attributes))


def _variable(dimensions: tuple[str, ...], attributes: Mapping[str, Any], stored: Any) -> NetcdfVariable:
    """Return a variable in float64, without its fills, scaled."""
    raw = np.asarray(stored)
    values = raw.astype(np.float64)
    fills = [np.ravel(np.asarray(attributes[name], np.float64)) for name in FILLS if _is_number(attributes.get(name))]
    if fills:
        values = np.where(np.isin(values, np.concatenate(fills)), np.nan, values)
    factor = _number(attributes.get("scale_factor"), 1.0)
    added = _number(attributes.get("add_offset"), 0.0)
    if (factor, added) != (1.0, 0.0):
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is missing
            values = values * factor + added
    return NetcdfVariable(tuple(dimensions), attributes, values)


def _is_number(value: Any) -> bool:
    return value is not None and np.size(value) > 0 and np.asarray(value).dtype.kind in "fiu"


def _number(value: Any, usual: float) -> float:
    """Return an attribute of one number; `usual` where absent."""
    return float(np.ravel(value)[0]) if _is_number(value) else usual
