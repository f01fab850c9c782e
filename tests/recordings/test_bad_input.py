"""Everything that a measured log can do wrong: one line that says what, where, and what to do."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from recordings import read_recording
from recordings.units import parse_maps
from scenarios.errors import InputError
from tests.recordings.conftest import restrained

N = 40
Make = Callable[[Path], Path]


def good() -> dict[str, Any]:
    angle = np.linspace(0, 6, N)
    field = {"mag_x_nT": 30_000 * np.cos(angle), "mag_y_nT": 30_000 * np.sin(angle), "mag_z_nT": 1e4 + angle}
    return {"time_s": np.arange(N) * 0.1, **field}


def parquet(**changes: Any) -> Make:
    """A good log with changed columns; None removes one."""

    def make(tmp: Path) -> Path:
        columns = {name: values for name, values in {**good(), **changes}.items() if values is not None}
        pq.write_table(pa.table(columns), tmp / "log.parquet")
        return tmp / "log.parquet"

    return make


def changed(name: str, row: int, value: float) -> Make:
    """A good log with one other value; rows from 1."""
    values = good()[name].copy()
    values[row - 1] = value
    return parquet(**{name: values})


def times(factor: float, **more: Any) -> Make:
    return parquet(**{name: factor * values for name, values in good().items() if name != "time_s"}, **more)


def csv(edit: Callable[[list[str]], list[str]] = list) -> Make:
    """A good CSV file with its lines edited (line 0 is the header)."""

    def make(tmp: Path) -> Path:
        rows = zip(*good().values(), strict=True)
        lines = [",".join(good()), *(",".join(f"{v:.6f}" for v in row) for row in rows)]
        (tmp / "log.csv").write_text("\n".join(edit(lines)) + "\n")
        return tmp / "log.csv"

    return make


def content(data: bytes, name: str) -> Make:
    def make(tmp: Path) -> Path:
        (tmp / name).write_bytes(data)
        return tmp / name

    return make


def damaged(where: slice) -> Make:
    def make(tmp: Path) -> Path:
        path = parquet()(tmp)
        path.write_bytes(path.read_bytes()[where])
        return path

    return make


def overwritten(tmp: Path) -> Path:
    path = parquet()(tmp)
    data = bytearray(path.read_bytes())
    data[4:60] = b"\xff" * 56
    path.write_bytes(data)
    return path


def with_gap(tmp: Path) -> Path:
    values = np.linspace(0, 1, N)
    values[10:30] = np.nan
    return parquet(temperature_degC=values)(tmp)


def quaternion(w: float) -> dict[str, Any]:
    q = {"att_qw": np.ones(N), "att_qx": np.zeros(N), "att_qy": np.zeros(N), "att_qz": np.zeros(N)}
    q["att_qw"][4] = w
    return q


def half_empty(tmp: Path) -> Path:
    even = np.arange(N) % 2 == 0
    nan = np.full(N, np.nan)
    x, y = np.where(even, 0.1, nan), np.where(even, nan, 0.1)
    return parquet(gyro_x_rad_s=x, gyro_y_rad_s=y, gyro_z_rad_s=x)(tmp)


def header_twice(lines: list[str]) -> list[str]:
    return [lines[0].replace("mag_y_nT", "mag_x_nT"), *lines[1:]]


def column_twice(tmp: Path) -> Path:
    table = pa.table(good())
    pq.write_table(table.append_column("mag_x_nT", table.column("mag_x_nT")), tmp / "log.parquet")
    return tmp / "log.parquet"


def stamps_without_the_first(tmp: Path) -> Path:
    stamps = pa.array([None, *range(1, N)], pa.timestamp("ms"))
    return parquet(time_s=stamps)(tmp)


def cell(line: int, old: str, new: str) -> Callable[[list[str]], list[str]]:
    def edit(lines: list[str]) -> list[str]:
        assert old in lines[line]
        return [*lines[:line], lines[line].replace(old, new), *lines[line + 1 :]]

    return edit


ROW_5 = "0.400000,"
LIST = pa.array([[1.0, 2.0, 3.0]] * N)
BACK = np.r_[np.arange(20), np.arange(20) + 5.0]
AGAIN = np.repeat(np.arange(20.0), 2)

CASES: dict[str, tuple[Make, list[str], tuple[str, ...]]] = {
    "file missing": (lambda tmp: tmp / "log.csv", [], ("no such file", "check the path")),
    "a directory": (lambda tmp: tmp, [], ("dataset.json: no such file", "give a directory")),
    "empty file": (content(b"", "log.csv"), [], ("is empty",)),
    "empty parquet": (content(b"", "log.parquet"), [], ("is empty",)),
    "cut-off parquet": (damaged(slice(0, -40)), [], ("cut off or damaged",)),
    "first bytes only": (damaged(slice(0, 6)), [], ("cut off or damaged",)),
    "damaged inside": (overwritten, [], ("cut off or damaged",)),
    "text called parquet": (content(b"time_s,mag\n1,2\n2,3\n", "log.parquet"), [], ("no column mag_x_nT",)),
    "other kind": (content(b"MATLAB 5.0 MAT-file", "log.mat"), [], ("is neither Parquet", "IAGA-2002 nor CSV", ".csv")),
    "autopilot's log": (
        content(b"ULog\x01\x12\x35", "log.ulg"),
        [],
        ("is no ULog, or cut off in its header",),
    ),
    "binary called csv": (content(b"\xff\xfe\x00\x12" * 99, "log.csv"), [], ("not a text table",)),
    "zip called csv": (content(b"PK\x03\x04\x00\x00" * 99, "log.csv"), [], ("not a text table",)),
    "header only": (csv(lambda lines: lines[:1]), [], ("holds 0 samples",)),
    "header only, parquet": (
        parquet(**{name: pa.array([], pa.float64()) for name in good()}),
        [],
        ("holds 0 samples", "at least 10"),
    ),
    "one sample": (csv(lambda lines: lines[:2]), [], ("holds 1 samples", "at least 10", "longer")),
    "column twice": (column_twice, [], ("log.parquet: mag_x_nT", "two columns of this name")),
    "header twice": (csv(header_twice), [], ("mag_x_nT", "two columns", "rename")),
    "text in a channel": (parquet(rpm=["1"] * 7 + ["bad"] + ["2"] * 32), [], ("rpm: row 8 is 'bad'", "correct")),
    "numbers as text": (parquet(mag_x_nT=["1.5"] * N), [], ("mag_x_nT", "stored as text")),
    "text for a field": (parquet(mag_y_nT=["north"] * N), [], ("mag_y_nT", "holds 'north'", "--map")),
    "wrong shape": (parquet(mag_x_nT=LIST), [], ("mag_x_nT", "list", "split")),
    "wrong shape, other name": (
        parquet(mag_x_nT=None, mag_y_nT=None, mag_z_nT=None, mag=LIST),
        [],
        ("no column mag_x_nT", "mag (list<"),
    ),
    "mag missing": (
        parquet(mag_z_nT=None, foo=np.ones(N)),
        [],
        ("no column mag_z_nT", "has time_s", "foo", "--map mag_z_nT=bz,unit=uT"),
    ),
    "one time in every row": (parquet(time_s=np.ones(N)), [], ("time_s: row 2 repeats the time 1.0", "38 more")),
    "array with a hole": (
        parquet(**{f"mag_{a}_nT": None for a in "xyz"}, mag1_x_nT=np.ones(N), mag1_y_nT=np.ones(N)),
        [],
        ("no column mag1_z_nT",),
    ),
    "array with a gap": (
        parquet(
            **{f"mag_{a}_nT": None for a in "xyz"},
            **{f"mag{k}_{a}_nT": good()[f"mag_{a}_nT"] for k in (1, 3) for a in "xyz"},
        ),
        [],
        ("the sensors 1, 3 of an array, without 2", "--map mag2_x_nT=mag3_x_nT"),
    ),
    "sensor and array": (parquet(mag1_x_nT=np.ones(N)), [], ("both mag_x_nT", "keep one")),
    "gyro incomplete": (parquet(gyro_x_rad_s=np.ones(N)), [], ("gyro_y_rad_s beside gyro_x_rad_s", "rename")),
    "all of mag empty": (parquet(mag_x_nT=pa.nulls(N)), [], ("mag_x_nT", "40 of 40")),
    "inf in gyro": (
        parquet(gyro_x_rad_s=np.ones(N), gyro_y_rad_s=np.full(N, np.inf), gyro_z_rad_s=np.ones(N)),
        [],
        ("gyro_y_rad_s", "40 of 40", "row 1", "infinite"),
    ),
    "outage": (with_gap, [], ("temperature_degC", "no value for 2.1 s from row 11 on, 20 rows", "cut")),
    "never all three": (half_empty, [], ("gyro_x_rad_s, gyro_y_rad_s", "no row has a value in every")),
    "axis stuck": (parquet(mag_x_nT=np.full(N, 512.0)), [], ("mag_x_nT: is 512 in every row", "stuck")),
    "all axes stuck": (
        parquet(**{f"mag_{a}_nT": np.full(N, 3e4) for a in "xyz"}),
        [],
        ("all three axes are constant", "mag_z_nT"),
    ),
    "field in uT": (times(1e-3), [], ("mag_x_nT", "not between 1000 and 500000 nT", "like uT", "unit=uT")),
    "field in mG": (times(1e-2), [], ("like mG", "--map mag_x_nT=<column>,unit=mG")),
    "field in G": (times(1e-5), [], ("like G", "unit=G")),
    "field in T": (times(1e-9), [], ("like T", "unit=T")),
    "field in pT": (times(1e3), [], ("like pT", "unit=pT")),
    "field in counts": (times(5e-3 / 31.6), [], ("5.0", "raw counts", "scale=")),
    "unit twice": (parquet(), [f"mag_{a}_nT=mag_{a}_nT,unit=uT" for a in "xyz"], ("3.162e7", "like pT")),
    "quaternion not unit": (parquet(**quaternion(2.0)), [], ("att_qw", "row 5 has norm 2", "w x y z")),
    "quaternion zero": (parquet(**quaternion(0.0)), [], ("row 5 has norm 0",)),
    "map of unknown column": (parquet(), ["mag_x_nT=bx"], ("no column 'bx'", "has time_s, mag_x_nT")),
}


@pytest.mark.parametrize(("make", "maps", "words"), CASES.values(), ids=CASES)
def test_log_is_refused_in_one_line(tmp_path: Path, make: Make, maps: list[str], words: tuple[str, ...]) -> None:
    path = make(tmp_path)
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(InputError) as caught:
        read_recording(path, maps=maps)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < len(str(path)) + 400
    assert caught.value.do
    for word in words:
        assert word in message
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize(
    ("maps", "words"),
    [
        (["mag_x_nT"], ("--map mag_x_nT: is not of the form TARGET=SOURCE", "unit=uT")),
        (["=bx"], ("not of the form",)),
        (["mag_x_nT="], ("not of the form",)),
        (["mag_x_nT=bx,uT"], ("cannot use 'uT'",)),
        (["mag_x_nT=bx,unit="], ("cannot use 'unit='",)),
        (["mag_x_nT=bx,units=uT"], ("cannot use 'units=uT'",)),
        (["mag_x_nT=bx,unit=uT,unit=T"], ("cannot use 'unit=T'",)),
        (["mag_x_nT=bx,unit=furlong"], ("unit furlong is not known", "mag_x_nT takes nT, pT, uT")),
        (["mag_x_nT=bx,unit=rad/s"], ("unit rad/s is for gyro", "mag_x_nT takes nT")),
        (["att_qw=q0,unit=m"], ("unit m is for position", "att_qw takes no unit")),
        (["mag_x_nT=bx,scale=two"], ("scale 'two' is not a number",)),
        (["mag_x_nT=bx,scale=0"], ("scale '0' is not a number other than zero",)),
        (["mag_x_nT=bx,scale=nan"], ("scale 'nan'",)),
        (["mag_X_nT=bx"], ("no column 'mag_X_nT'", "use mag_x_nT")),
        (["wheel=rpm"], ("no column 'wheel'", "time_s, mag_x_nT")),
        (["true_qw=q"], ("no column 'true_qw'",)),
        (["mag_x_nT=bx", "mag_x_nT=by"], ("--map mag_x_nT: is given twice",)),
    ],
)
def test_map_is_refused_in_one_line(maps: list[str], words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        parse_maps(maps)
    assert str(caught.value).startswith("--map ")
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.skipif(not restrained(), reason="this user may read everything")
def test_file_without_permission(tmp_path: Path) -> None:
    path = parquet()(tmp_path)
    path.chmod(0)
    with pytest.raises(InputError, match="permission denied"):
        read_recording(path)
