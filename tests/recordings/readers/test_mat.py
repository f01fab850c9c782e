"""MATLAB's files: structs, vectors in rows and columns, lengths that differ, every version, and damage."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from recordings import read_recording
from recordings.assemble import arrays_of
from recordings.columns import ACCEL, ATTITUDE, GYRO
from recordings.readers import load, mat
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import Swing, assert_read_or_refused, assert_the_same_field, damaged, swing


def save(path: Path, **variables: object) -> Path:
    scipy.io.savemat(path, variables)
    return path


@pytest.mark.parametrize("name", ["mag", "m", "B", "magnetometer", "Mag", "mag_raw", "data"])
@pytest.mark.parametrize("rows", [True, False])
def test_a_vector_by_its_name(name: str, rows: bool, tmp_path: Path) -> None:
    of = swing(60)
    values = of.mag_nT / 1e3
    path = save(tmp_path / "log.mat", t=of.time_s, **{name: values if rows else values.T}, fs=20.0)
    assert_the_same_field(read_recording(path), of, 1e-6)


def test_a_struct_of_sensors(tmp_path: Path) -> None:
    of = swing(400)
    imu = {"time": of.time_s, "mag": of.mag_nT, "gyr": of.rate_rad_s, "acc": of.accel_m_s2, "quat": of.wxyz()}
    gps = {"time": of.time_s[::10], "lat": np.full(40, 47.0)}
    path = save(tmp_path / "log.mat", s={"imu": imu, "gps": gps, "name": "sensor"}, gain=np.eye(3))
    found = read_recording(path)
    assert_the_same_field(found, of, 1e-6)
    assert {GYRO[0], ACCEL[0], ATTITUDE[0]} <= arrays_of(found).keys()
    assert "2 arrays of other lengths than the magnetometer's 400 rows left out" in found.origin.notes
    names = load(path, lambda name: True).table.column_names
    assert names[:4] == ["s.imu.time", "s.imu.mag_x", "s.imu.mag_y", "s.imu.mag_z"]


def test_components_in_arrays_of_their_own(tmp_path: Path) -> None:
    of = swing(80)
    x, y, z = of.mag_nT.T
    path = save(tmp_path / "log.mat", time=of.time_s, Bx=x, By=y, Bz=z, calm=np.zeros((300, 2)))
    assert_the_same_field(read_recording(path), of, 1e-6)


@pytest.mark.parametrize("options", [{"format": "4"}, {"format": "5", "do_compression": True}])
def test_other_versions(options: dict[str, object], tmp_path: Path) -> None:
    of = swing(60)
    scipy.io.savemat(tmp_path / "log.mat", {"t": of.time_s, "mag": of.mag_nT}, **options)
    assert_the_same_field(read_recording(tmp_path / "log.mat"), of, 1e-6)


def newest(path: Path, of: Swing) -> Path:
    """Version 7.3: HDF5 behind 512 bytes of text, arrays stored by column."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"t": of.time_s[None], "mag": of.mag_nT.T}.items():
            made = file.create_dataset(f"log/{name}", data=values)
            made.attrs["MATLAB_class"] = np.bytes_(b"double")
        file["log"].attrs["MATLAB_class"] = np.bytes_(b"struct")
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
    with path.open("r+b") as raw:
        raw.write(text)
    return path


def test_version_7_3(tmp_path: Path) -> None:
    of = swing(60)
    assert_the_same_field(read_recording(newest(tmp_path / "log.mat", of)), of, 1e-6)


def test_no_array(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no array of numbers"):
        read_recording(save(tmp_path / "log.mat", text="words", gain=2.0))


def test_a_compressed_file_larger_than_what_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mat, "MOST_VALUES", 10**5)
    scipy.io.savemat(tmp_path / "log.mat", {"mag": np.zeros((9 * 10**5, 1), np.uint8)}, do_compression=True)
    with pytest.raises(InputError, match="more than 800000 bytes are compressed"):
        read_recording(tmp_path / "log.mat")


@DAMAGED_FILES
@pytest.mark.parametrize("version", ["4", "5", "7", "7.3"])
def test_damage(version: str, files: int, tmp_path: Path) -> None:
    of, path = swing(60), tmp_path / "log.mat"
    if version == "7.3":
        newest(path, of)
    else:
        packed = {"do_compression": True} if version == "7" else {}
        about = {"t": of.time_s, "mag": of.mag_nT, **({} if version == "4" else {"s": {"a": of.rate_rad_s}})}
        scipy.io.savemat(path, about, format="4" if version == "4" else "5", **packed)
    assert_read_or_refused(path, damaged(path.read_bytes(), files))
