"""NetCDF: a Seaglider's dive, OG1, files of other origin, netCDF-3, and damage."""

from __future__ import annotations

import datetime
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
import scipy.io

from recordings import read_recording
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import (
    DOWN,
    Swing,
    assert_read_or_refused,
    assert_the_same_field,
    damaged,
    swing,
)

COUNT_NT = 100.0
START_S = 1_716_819_828.0
"""27 May 2024, 14:23:48 UTC."""
VARIATION_DEG, PITCH_BIAS_DEG = -1.25, 0.75
SINCE = "seconds since 1970-1-1 00:00:00"


def variable(file: h5netcdf.File, name: str, dimension: str, values: np.ndarray, **attributes: object) -> None:
    made = file.create_variable(name, (dimension,) if dimension else (), "f8", data=values)
    made.attrs.update(attributes)


def dive(path: Path, of: Swing) -> Path:
    """A dive file: engineering data, a CTD of half the rate, motions of the pitch mass."""
    time_s = START_S + of.time_s
    counts = np.round(of.mag_nT @ DOWN / COUNT_NT)
    roll, pitch, yaw = of.roll_pitch_yaw_deg.T
    ctd_s = time_s[::2]
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"sg": len(time_s), "magnetometer": len(time_s), "ctd": len(ctd_s), "gc": 2, "gps": 3}
        variable(file, "time", "sg", time_s, units=SINCE)
        for name, values in zip("xyz", counts.T, strict=True):
            variable(file, f"eng_mag_{name}", "magnetometer", values)
        variable(file, "eng_rollAng", "sg", roll, units="degrees")
        variable(file, "eng_pitchAng", "sg", pitch + PITCH_BIAS_DEG, units="degrees")
        variable(file, "eng_head", "sg", (yaw - VARIATION_DEG) % 360, units="degrees")
        variable(file, "depth", "sg", np.linspace(2, 30, len(time_s)), units="meters")
        variable(file, "magnetic_variation", "", np.array(VARIATION_DEG))
        variable(file, "sg_cal_pitchbias", "", np.array(PITCH_BIAS_DEG))
        variable(file, "ctd_time", "ctd", ctd_s, units=SINCE)
        variable(file, "latitude", "ctd", 12.13 + 1e-5 * np.arange(len(ctd_s)), _FillValue=np.float64(-999.0))
        variable(file, "longitude", "ctd", 85.92 + 0 * ctd_s)
        variable(file, "temperature", "ctd", np.linspace(30, 28, len(ctd_s)))
        variable(file, "salinity", "ctd", np.linspace(33, 34, len(ctd_s)))
        variable(file, "log_gps_lat", "gps", np.array([12.13, 12.131, 12.14]))
        variable(file, "log_gps_lon", "gps", np.array([85.92, 85.921, 85.92]))
        variable(file, "gc_st_secs", "gc", time_s[[0, len(time_s) // 2]], units=SINCE)
        variable(file, "gc_end_secs", "gc", time_s[[len(time_s) // 4, 3 * len(time_s) // 4]], units=SINCE)
        variable(file, "gc_pitch_ad_start", "gc", np.array([100.0, 1100.0]))
        variable(file, "gc_pitch_ad", "gc", np.array([1100.0, 600.0]))
    return path


def test_a_dive_gives_the_field_back_to_half_a_count(tmp_path: Path) -> None:
    of = swing(401)
    found = read_recording(dive(tmp_path / "p1710100.nc", of))
    assert found.origin.unit == "count"
    assert found.origin.place == (12.131, 85.92, 0.0)
    assert found.origin.date == datetime.date(2024, 5, 27)
    assert_the_same_field(found, of, COUNT_NT / 2 + 1e-6, COUNT_NT)
    np.testing.assert_allclose(found.time_s, of.time_s, atol=1e-5)
    notes = " ".join(found.origin.notes)
    for told in ("raw counts", "this same magnetometer", "declination -1.25 deg", "pitch's bias 0.75 deg"):
        assert told in notes


def test_the_rest_of_a_dive(tmp_path: Path) -> None:
    found = read_recording(dive(tmp_path / "p1710100.nc", swing(401)))
    assert found.pos_enu_m is not None
    assert found.temperature_degC is not None
    np.testing.assert_allclose(found.pos_enu_m[-1], [0, 2e-3 * 6_371_008.8 * np.pi / 180, -30], atol=0.01)
    assert found.temperature_degC[200] == pytest.approx(29)
    assert found.channels["salinity"][200] == pytest.approx(33.5)
    mass = found.channels["gc_pitch_ad"]
    np.testing.assert_allclose(mass[[50, 100, 150, 250, 300, 400]], [600, 1100, 1100, 850, 600, 600], atol=0.01)


def test_a_dive_without_ctd_and_angles(tmp_path: Path) -> None:
    of = swing(40)
    with h5netcdf.File(tmp_path / "p.nc", "w") as file:
        file.dimensions = {"sg": 40}
        variable(file, "time", "sg", START_S + of.time_s, units=SINCE)
        for name, values in zip("xyz", (of.mag_nT @ DOWN).T, strict=True):
            variable(file, f"eng_mag_{name}", "sg", values)
    found = read_recording(tmp_path / "p.nc")
    assert found.att_q is None
    np.testing.assert_allclose(found.mag_nT, of.mag_nT)


def test_og1_with_gaps_of_the_magnetometer(tmp_path: Path) -> None:
    """One dimension of all instruments: a row in two is the magnetometer's."""
    of = swing(400)
    shown = np.where(np.arange(400)[:, None] % 2 == 0, of.mag_nT / 1e3, np.nan)
    with h5netcdf.File(tmp_path / "sea076_R.nc", "w") as file:
        file.dimensions = {"N_MEASUREMENTS": 400, "N_PARAM": 7}
        variable(file, "TIME", "N_MEASUREMENTS", START_S + of.time_s, units="seconds since 1970-01-01T00:00:00Z")
        for axis, values in zip("XYZ", shown.T, strict=True):
            variable(file, f"MAG_{axis}", "N_MEASUREMENTS", values, units="uT", long_name=f"field {axis}")
        variable(file, "LATITUDE", "N_MEASUREMENTS", np.full(400, 58.2), standard_name="latitude")
        variable(file, "LONGITUDE", "N_MEASUREMENTS", np.full(400, 11.4), standard_name="longitude")
        variable(file, "DEPTH", "N_MEASUREMENTS", np.linspace(0, 50, 400), units="m", standard_name="depth")
        variable(file, "PARAMETER", "N_PARAM", np.arange(7.0))
    found = read_recording(tmp_path / "sea076_R.nc")
    np.testing.assert_allclose(found.mag_nT, of.mag_nT[::2], atol=1e-6)
    assert found.origin.place == (58.2, 11.4, 0.0)
    assert found.origin.date == datetime.date(2024, 5, 27)
    assert found.channels["pos_up_m"][-1] == pytest.approx(-50 * 398 / 399)


def test_names_that_only_the_long_names_tell(tmp_path: Path) -> None:
    of = swing(50)
    with h5netcdf.File(tmp_path / "mooring.nc", "w") as file:
        file.dimensions = {"time": 50}
        variable(file, "time", "time", of.time_s / 86_400, units="days since 2024-05-01")
        for k, axis in enumerate("xyz"):
            name = f"magnetic field {axis}"
            variable(file, f"v{k}", "time", of.mag_nT[:, k], units="nT", long_name=name)
    found = read_recording(tmp_path / "mooring.nc")
    np.testing.assert_allclose(found.mag_nT, of.mag_nT)
    np.testing.assert_allclose(found.time_s, of.time_s, atol=1e-6)


def classic(path: Path, of: Swing) -> Path:
    """NetCDF-3 with packed integers: value = 0.5 stored + 100, and -32768 for no value."""
    with scipy.io.netcdf_file(path, "w") as file:
        file.createDimension("time", len(of.time_s))
        for name, values in {"time": of.time_s, **{f"b{a}": of.mag_nT[:, k] for k, a in enumerate("xyz")}}.items():
            packed = name != "time"
            made = file.createVariable(name, "i" if packed else "d", ("time",))
            stored = np.round((values - 100) / 0.5) if packed else values
            stored[7] = -(2**31) if packed else stored[7]
            made[:] = stored
            if packed:
                made.units, made.scale_factor, made.add_offset = "nT", np.float64(0.5), np.float64(100)
                made._FillValue = np.int32(-(2**31))
            else:
                made.units = "seconds since 2024-05-01 12:00:00"
    return path


def test_netcdf_3_with_packed_values(tmp_path: Path) -> None:
    of = swing(100)
    found = read_recording(classic(tmp_path / "a.nc", of))
    assert len(found.time_s) == 99
    np.testing.assert_allclose(found.mag_nT, np.delete(of.mag_nT, 7, axis=0), atol=0.26)


def test_what_holds_no_magnetometer_lists_its_variables(tmp_path: Path) -> None:
    with h5netcdf.File(tmp_path / "ctd.nc", "w") as file:
        file.dimensions = {"time": 9}
        variable(file, "salinity", "time", np.arange(9.0))
    with pytest.raises(InputError, match="no magnetometer that its names tell; its variables are salinity"):
        read_recording(tmp_path / "ctd.nc")


def test_a_file_that_declares_more_than_fits(tmp_path: Path) -> None:
    """Two bytes of a chunk stand for 8 GB of zeros."""
    with h5netcdf.File(tmp_path / "huge.nc", "w") as file:
        file.dimensions = {"time": 10**9}
        file.create_variable("mag_x", ("time",), "f8", chunks=(10**6,))
    with pytest.raises(InputError, match=r"holds 1e9 numbers, at most 4e7"):
        read_recording(tmp_path / "huge.nc")


@DAMAGED_FILES
@pytest.mark.parametrize("form", [dive, classic])
def test_damage(form: object, files: int, tmp_path: Path) -> None:
    path = form(tmp_path / "a.nc", swing(61))  # type: ignore[operator]
    assert_read_or_refused(path, damaged(path.read_bytes(), files))
