"""MATLAB, netCDF and IAGA-2002 as people write them: structs, cells, groups, calendars, stations."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pytest
from scipy.io import savemat

from recordings import read_recording
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import assert_read_or_refused, assert_the_same_field, damaged, swing

OF = swing(200)
FIELD_UT = OF.mag_nT / 1e3
NOON_S, MAY_1 = 1_714_564_800.0, datetime.date(2024, 5, 1)
UNIX_S = OF.time_s + NOON_S


def structs() -> np.ndarray:
    """An array of structs, one a sample."""
    found = np.zeros((1, len(OF.time_s)), dtype=[("t", object), ("mag", object), ("gyro", object)])
    for k, t in enumerate(OF.time_s):
        found[0, k] = (t, FIELD_UT[k : k + 1], OF.rate_rad_s[k : k + 1].T)
    return found


def cells() -> np.ndarray:
    """A cell a number, as `num2cell` gives."""
    found = np.empty(FIELD_UT.shape, object)
    for at, value in np.ndenumerate(FIELD_UT):
        found[at] = value
    return found


MATLAB: dict[str, dict[str, Any]] = {
    "array of structs": {"log": structs()},
    "struct": {"log": {"t": OF.time_s, "mag": FIELD_UT.T, "gyr": OF.rate_rad_s, "name": "boat"}},
    "cells": {"t": OF.time_s, "mag": cells()},
    "datenum": {"time": OF.time_s / 86_400 + 739_373.5, "mag": FIELD_UT},
    "time and vector": {"data": np.column_stack([OF.time_s, FIELD_UT])},
    "vector of any name": {"t": OF.time_s, "D": FIELD_UT},
}


@pytest.mark.parametrize("form", MATLAB)
@pytest.mark.parametrize("packed", [True, False])
def test_matlab(form: str, packed: bool, tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", MATLAB[form], do_compression=packed)
    found = read_recording(tmp_path / "log.mat")
    assert_the_same_field(found, OF, 0.1)
    assert found.origin.timed
    np.testing.assert_allclose(found.time_s - found.time_s[0], OF.time_s, atol=1e-4)
    assert (found.gyro_rad_s is not None) == ("struct" in form)
    assert found.origin.date == (MAY_1 if form == "datenum" else None)


@DAMAGED_FILES
@pytest.mark.parametrize("form", ["array of structs", "cells"])
def test_damaged_structs_and_cells(form: str, files: int, tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", MATLAB[form])
    assert_read_or_refused(tmp_path / "log.mat", damaged((tmp_path / "log.mat").read_bytes(), files // 6))


def netcdf(path: Path, groups: dict[str, dict[str, Any]], attributes: dict[str, float]) -> Path:
    """A file of groups, "" its own: variable -> (dimensions, values, units)."""
    with h5netcdf.File(path, "w") as file:
        for name, variables in groups.items():
            group = file.create_group(name) if name else file
            for key, (dimensions, values, unit) in variables.items():
                for dimension, size in zip(dimensions, np.shape(values), strict=True):
                    if dimension not in group.dimensions:
                        group.dimensions[dimension] = size
                group.create_variable(key, dimensions, data=values).attrs["units"] = unit
        file.attrs.update(attributes)
    return path


TIME = {"time": (("time",), UNIX_S, "seconds since 1970-01-01")}
MAG = {"mag": (("axis", "time"), FIELD_UT.T, "microtesla")}
STATION = {"lat": ((), 47.37, "degrees_north"), "lon": ((), 8.55, "degrees_east"), "altitude": ((), 400.5, "m")}
DRIFT = {
    "m_lat": (("time",), np.full(200, 4722.2), "lat"),
    "m_lon": (("time",), np.full(200, 833.0), "lon"),
}
BOUNDS = {
    **{f"geospatial_lat_{end}": 47.37 for end in ("min", "max")},
    **{f"geospatial_lon_{end}": 8.55 for end in ("min", "max")},
}
NETCDF: dict[str, tuple[dict[str, dict[str, Any]], dict[str, float]]] = {
    "axis first, bounds": ({"": TIME | MAG}, BOUNDS),
    "station": ({"": TIME | MAG | STATION}, {}),
    "group": ({"": STATION, "imu": TIME | MAG}, {}),
    "time above the group": ({"": TIME | STATION, "imu": MAG}, {}),
    "Slocum": ({"": TIME | MAG | DRIFT}, {}),
}


@pytest.mark.parametrize("form", NETCDF)
def test_netcdf(form: str, tmp_path: Path) -> None:
    found = read_recording(netcdf(tmp_path / "log.nc", *NETCDF[form]))
    assert_the_same_field(found, OF, 0.1)
    np.testing.assert_allclose(found.time_s - found.time_s[0], OF.time_s, atol=1e-4)
    assert found.origin.date == MAY_1
    assert found.origin.place == pytest.approx((47.37, 8.55, 400.5 if STATION.keys() & {*NETCDF[form][0][""]} else 0))


def test_an_observatory_tells_its_place(tmp_path: Path) -> None:
    head = [
        " Format                 IAGA-2002                                    |",
        " Geodetic Latitude      52.072                                       |",
        " Geodetic Longitude     12.675                                       |",
        " Elevation              78                                           |",
        "DATE       TIME         DOY     NGKX      NGKY      NGKZ      NGKF   |",
    ]
    x, y, z = 18_700 + 40 * np.sin(OF.time_s), 1_300 + 30 * np.cos(OF.time_s), 46_000 + 20 * np.sin(2 * OF.time_s)
    strength = np.hypot(x, z)
    rows = [
        f"2024-05-01 12:{k // 60:02}:{k % 60:02}.000 122    "
        + " ".join(f"{part[k]:9.2f}" for part in (x, y, z, strength))
        for k in range(200)
    ]
    (tmp_path / "ngk.sec").write_text("\n".join([*head, *rows]) + "\n")
    found = read_recording(tmp_path / "ngk.sec").origin
    assert found.place == (52.072, 12.675, 78.0)
    assert found.date == MAY_1
