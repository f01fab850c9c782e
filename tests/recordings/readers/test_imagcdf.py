"""ImagCDF: elements to X, Y, Z, missing values, place and date, and damage."""

from __future__ import annotations

import datetime
import zlib
from pathlib import Path

import cdflib
import numpy as np
import pytest

from recordings import read_recording
from recordings.readers import imagcdf, load
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import assert_read_or_refused, damaged

FILL = 99_999.0
VECTOR_TIMES = "GeomagneticVectorTimes"


def observatory(
    path: Path, elements: dict[str, np.ndarray], times: str = "GeomagneticVectorTimes", gzip: int = 0
) -> Path:
    rows = len(next(iter(elements.values())))
    file = cdflib.cdfwrite.CDF(path, cdf_spec={"Compressed": gzip}, delete=True)
    file.write_globalattrs(
        {
            "FormatDescription": {0: "INTERMAGNET CDF Format"},
            "Latitude": {0: [40.137, "CDF_DOUBLE"]},
            "Longitude": {0: [254.763, "CDF_DOUBLE"]},
            "Elevation": {0: [1682.0, "CDF_DOUBLE"]},
        }
    )
    about = {"Num_Elements": 1, "Rec_Vary": True, "Dim_Sizes": [], "Compress": gzip}
    for name, values in elements.items():
        told = {"FILLVAL": [FILL, "CDF_DOUBLE"]}
        file.write_var({"Variable": f"GeomagneticField{name}", "Data_Type": 45, **about}, told, values)
    start = cdflib.cdfepoch.compute_tt2000([2016, 12, 31, 23, 59, 0, 0, 0, 0])
    ticks = np.int64(start) + 1_000_000_000 * np.arange(rows, dtype=np.int64)
    file.write_var({"Variable": times, "Data_Type": 33, **about}, var_data=ticks)
    file.close()
    return path


def day(rows: int = 90) -> dict[str, np.ndarray]:
    wave = np.sin(np.arange(rows) / 9)
    return {"X": 20_000 + 30 * wave, "Y": 1_000 - 20 * wave, "Z": 44_000 + 10 * wave, "S": 48_350 + wave}


@pytest.mark.parametrize("gzip", [0, 6])
def test_elements_times_and_place(gzip: int, tmp_path: Path) -> None:
    elements = day()
    elements["Y"][[3, 8]] = FILL
    elements["S"][5] = FILL
    found = read_recording(observatory(tmp_path / "bou.cdf", elements, gzip=gzip))
    known = np.delete(np.arange(90), [3, 8])
    np.testing.assert_array_equal(found.mag_nT, np.column_stack([elements[name] for name in "XYZ"])[known])
    np.testing.assert_array_equal(found.time_s, known)  # a leap second within is a second
    assert load(tmp_path / "bou.cdf", lambda name: True).table.column("scalar_nT").null_count == 1
    assert found.origin.place == (40.137, 254.763, 1682.0)
    assert found.origin.date == datetime.date(2016, 12, 31)
    assert found.origin.notes[1:] == ("2 records without a value left out",)


def test_angles_are_degrees(tmp_path: Path) -> None:
    """H = 20,000 nT, D = 3 degrees, I = 60 degrees."""
    ones = np.ones(9)
    for elements in ({"H": 2e4, "D": 3.0, "Z": 2e4 * np.sqrt(3)}, {"D": 3.0, "I": 60.0, "F": 4e4}):
        path = observatory(tmp_path / "a.cdf", {name: value * ones for name, value in elements.items()}, "DataTimes")
        table = load(path, lambda name: True).table
        field = [table.column(f"mag_{axis}_nT")[0].as_py() for axis in "xyz"]
        np.testing.assert_allclose(field, [19_972.5907, 1_046.7191, 34_641.0162], atol=1e-3)


def test_cdf_of_another_kind(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no ImagCDF"):
        read_recording(observatory(tmp_path / "a.cdf", day(), times="Epoch"))
    with pytest.raises(InputError, match="gives the elements X, Z: no whole vector"):
        read_recording(observatory(tmp_path / "a.cdf", {name: day()[name] for name in "XZ"}))


@DAMAGED_FILES
@pytest.mark.parametrize("gzip", [0, 6])
def test_damage(gzip: int, files: int, tmp_path: Path) -> None:
    path = observatory(tmp_path / "a.cdf", day(40), gzip=gzip)
    assert_read_or_refused(path, damaged(path.read_bytes(), files))


@pytest.mark.parametrize("at", range(320, 900, 4))
def test_counts_and_offsets_of_any_value(at: int, tmp_path: Path) -> None:
    """Records that lead in a circle or count to two milliards are refused before they are followed."""
    whole = observatory(tmp_path / "a.cdf", day(20)).read_bytes()
    at %= len(whole) - 4
    values = (b"\x7f\xff\xff\xff", b"\x00\x00\x00\x08", b"\x00\x00\x01\x40")
    assert_read_or_refused(tmp_path / "a.cdf", (whole[:at] + value + whole[at + 4 :] for value in values))


def test_a_compressed_file_larger_than_what_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imagcdf, "MOST_VALUES", 10**6)
    packed = zlib.compress(bytes(9 * 10**6), 9, 31)
    (tmp_path / "a.cdf").write_bytes(b"\xcd\xf3\x00\x01\xcc\xcc\x00\x01" + bytes(32) + packed)
    with pytest.raises(InputError, match="more than 8000000 bytes are compressed"):
        read_recording(tmp_path / "a.cdf")
