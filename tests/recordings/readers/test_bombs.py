"""Small files that claim or expand to very much: refused in one line, with little memory."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from recordings.readers import load
from recordings.readers.cdf_records import DamagedCdfError, check_records
from recordings.readers.mat5 import MOST_ELEMENTS
from scenarios.errors import InputError

MOST_MB = 450
"""Of a process that reads all of these; the libraries alone take 200 MB."""
CHILD = """
import re, sys
from pathlib import Path
from recordings.readers import load
for name in sys.argv[1:]:
    try:
        print(name, len(load(Path(name), lambda column: True).table))
    except ValueError as error:
        print(str(error))
print(int(re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1]) // 1024)
"""
"""VmHWM is the process's own peak; ru_maxrss begins with that of the test run, which started it."""
PACKED = {"chunks": (1 << 20,), "compression": "gzip"}


def newest_mat(path: Path, fill: Callable[[h5py.File], object]) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        fill(file)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def never_written(file: h5py.File) -> None:
    file.create_dataset("mag", (13_000_000, 3), "f8", chunks=(100_000, 3), compression="gzip")


def one_array_of_many_names(file: h5py.File) -> None:
    values = file.create_dataset("mag", (9_000_000,), "f8", **PACKED)
    for k in range(200):
        file[f"again{k}"] = values
    file.create_dataset("mag_y", (19_000_000,), "f8", **PACKED)


def one_array_in_many_cells(file: h5py.File) -> None:
    values = file.create_dataset("#refs#/x", (5_000_000,), "f8", **PACKED)
    cells = file.create_dataset("cell", (500, 1), h5py.ref_dtype)
    cells[:, 0] = [values.ref] * 500
    cells.attrs["MATLAB_class"] = np.bytes_("cell")


def groups_within_groups(file: h5py.File) -> None:
    """Each group leads twice to the next: a walk that follows every link never ends."""
    group: h5py.Group = file
    for _ in range(40):
        group = group.create_group("a")
        group.parent["b"] = group


def much_text(file: h5py.File) -> None:
    text = file.create_dataset("s", (30_000_000,), "u2", **PACKED)
    text.attrs["MATLAB_class"] = np.bytes_("char")


def old_mat(path: Path, elements: list[bytes]) -> None:
    parts = [struct.pack("<II", 15, len(packed)) + packed for packed in map(zlib.compress, elements)]
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"".join(parts))


def netcdf(path: Path, **sizes: int) -> None:
    with h5py.File(path, "w") as file:
        for name, size in sizes.items():
            file.create_dataset(name, (size,), "f8", **PACKED)


def archives(equal: Path, lie: Path) -> None:
    """A phone's recording of equal rows, and the same that states a thousand bytes."""
    with zipfile.ZipFile(equal, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("Magnetometer.csv", "time,seconds_elapsed,z,y,x\n" + "1714564800000000000,0,1,2,3\n" * 2_300_000)
    data = bytearray(equal.read_bytes())
    place = data.rfind(b"PK\x01\x02")
    data[place + 24 : place + 28] = data[22:26] = struct.pack("<I", 1000)
    lie.write_bytes(data)


def parquet(path: Path, table: pa.Table) -> None:
    pq.write_table(table, path, compression="zstd")


def bombs(place: Path) -> dict[Path, str]:
    """The files, with what must be said of each."""
    for k, fill in enumerate((never_written, one_array_of_many_names)):
        newest_mat(place / f"expands{k}.mat", fill)
    for k, fill in enumerate((one_array_in_many_cells, groups_within_groups, much_text)):
        newest_mat(place / f"nothing{k}.mat", fill)
    old_mat(place / "zeros.mat", [struct.pack("<II", 9, 80_000_000) + bytes(80_000_000)] * 3)
    old_mat(place / "many.mat", [struct.pack("<II", 1, 0) * (MOST_ELEMENTS + 1)])
    netcdf(place / "large.nc", mag_x=30_000_000)
    archives(place / "equal.zip", place / "lie.zip")
    numbers = pa.array(np.zeros(7_000_000))
    parquet(place / "rows.parquet", pa.table(dict.fromkeys(("time_s", "mag_x_nT", "mag_y_nT", "mag_z_nT"), numbers)))
    words = pa.DictionaryArray.from_arrays(pa.array(np.zeros(10_000, np.int32)), ["x" * 1_000_000])
    schema = pa.schema({"time_s": pa.float64(), "phase": pa.string()})
    with pq.ParquetWriter(place / "words.parquet", schema) as file:
        for _ in range(3):
            file.write_table(pa.table({"time_s": np.zeros(100), "phase": words[:100].cast(pa.string())}, schema=schema))
    return {
        **{place / f"expands{k}.mat": "more than 50 times its size" for k in range(2)},
        **{place / f"nothing{k}.mat": "holds no array of numbers" for k in range(3)},
        place / "zeros.mat": "more than 200000000 bytes are compressed in it",
        place / "many.mat": f"it has more than {MOST_ELEMENTS} elements",
        place / "large.nc": "more than 50 times its size",
        place / "equal.zip": "more than 15 times its size",
        place / "lie.zip": "is cut off or damaged zip archive",
        place / "rows.parquet": "expands to 224 MB, more than 50 times its size",
        place / "words.parquet": "expands to 300 MB, more than 50 times its size",
    }


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system tells no peak of its own process")
def test_bombs_of_every_format_take_little_memory(tmp_path: Path) -> None:
    said = bombs(tmp_path)
    assert max(path.stat().st_size for path in said) < 2_000_000
    command = [sys.executable, "-c", CHILD, *map(str, said)]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path), OMP_NUM_THREADS="1")
    found = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout.splitlines()
    for line, (path, what) in zip(found, said.items(), strict=False):
        assert line.startswith(str(path)), line
        assert what in line
    assert len(found) == len(said) + 1
    assert int(found[-1]) < MOST_MB


def test_a_legitimate_recording_of_constant_columns_is_read(tmp_path: Path) -> None:
    """Noise in three columns, thirty that never change."""
    rng = np.random.default_rng(0)
    columns = {f"mag_{axis}_nT": rng.standard_normal(1_000_000) for axis in "xyz"}
    columns |= {f"c{k}": np.zeros(1_000_000) for k in range(30)}
    parquet(tmp_path / "log.parquet", pa.table(columns))
    assert load(tmp_path / "log.parquet", lambda name: True).table.num_columns == 33


def test_texts_keep_their_types(tmp_path: Path) -> None:
    words = ["a", None, "a"]
    kinds = (pa.string(), pa.large_string(), pa.binary(), pa.dictionary(pa.int32(), pa.string()))
    table = pa.table({f"{kind}": pa.array(words).cast(kind) for kind in kinds})
    parquet(tmp_path / "log.parquet", table)
    found = load(tmp_path / "log.parquet", lambda name: True).table
    assert found.equals(table)


def test_links_to_other_files_are_not_followed(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.nc", "w") as file:
        file.create_dataset("mag_x", data=np.zeros(100))

    def fill(file: h5py.File) -> None:
        file["mag_x"] = h5py.ExternalLink(str(tmp_path / "other.nc"), "mag_x")
        (tmp_path / "raw").write_bytes(bytes(800))
        file.create_dataset("raw", (100,), "f8", external=[(str(tmp_path / "raw"), 0, 800)])

    newest_mat(tmp_path / "log.mat", fill)
    with pytest.raises(InputError, match="holds no array of numbers"):
        load(tmp_path / "log.mat", lambda name: True)


def test_marks_of_streams_in_a_cdf_cost_no_copy_of_the_file() -> None:
    """A hundred thousand empty streams behind each other, each of twenty bytes."""
    data = b"\xcd\xf3\x00\x01\x00\x00\xff\xff" + zlib.compress(b"", wbits=31) * 100_000
    with pytest.raises(DamagedCdfError, match="more than 200000000 bytes are compressed"):
        check_records(data, 200_000_000)
