"""Reading a text log against pandas' own reader, in time and in memory against the size of the file."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv

from benchmarks.measure import Row, paired_ratio
from recordings.readers import load

MOST_TIME, MOST_TIME_BLANKS = 1.3, 2.5
"""Of a plain table, and of a table whose runs of blanks become tabs before Arrow reads it."""
MOST_MEMORY = 5.0
ROWS, SMALL_ROWS = 1_000_000, 20_000


def rows(small: bool = False) -> list[Row]:
    """Return the time of a plain table and of a table in blanks against pandas, and the growth of the peak memory."""
    count = SMALL_ROWS if small else ROWS
    with tempfile.TemporaryDirectory() as folder:
        plain, blanks = (Path(folder) / name for name in ("plain.csv", "blanks.txt"))
        _write(plain, count, ",")
        _write(blanks, count, "\t")
        blanks.write_bytes(blanks.read_bytes().replace(b"\t", b"   "))
        return [
            _time("read a text log / pandas.read_csv", plain, ",", MOST_TIME),
            _time("read a log with blanks / pandas.read_csv", blanks, r"\s+", MOST_TIME_BLANKS),
            _memory(plain, count),
        ]


def _write(path: Path, count: int, delimiter: str) -> None:
    rng = np.random.default_rng(1)
    columns = {"time_s": np.arange(count) * 0.01}
    columns |= {f"mag_{axis}_nT": np.round(rng.normal(0, 3e4, count), 1) for axis in "xyz"}
    options = pyarrow.csv.WriteOptions(delimiter=delimiter, quoting_style="none")
    pyarrow.csv.write_csv(pa.table(columns), path, options)


def _time(what: str, path: Path, delimiter: str, most: float) -> Row:
    read = lambda: load(path, lambda name: True)  # noqa: E731
    ratio, top, bottom = paired_ratio(read, lambda: pd.read_csv(path, sep=delimiter))
    note = f"file of {path.stat().st_size / 1e6:.1f} MB: {top:.2f} s, pandas {bottom:.2f} s"
    return Row(what, ratio, most, False, note)


def _memory(path: Path, count: int) -> Row:
    """Return how far reading raises the peak memory of a process that has done its imports, in sizes of the file."""
    code = (
        "import sys; from pathlib import Path; from recordings.readers import load\n"
        "peak = lambda: int(next(x for x in open('/proc/self/status') if x.startswith('VmHWM')).split()[1])\n"
        "before = peak(); load(Path(sys.argv[1]), lambda name: True); print((peak() - before) * 1024)"
    )
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    size = path.stat().st_size
    note = f"{count} rows, file of {size / 1e6:.1f} MB, growth of {float(run.stdout) / 1e6:.1f} MB"
    return Row("growth of memory in reading / size of the file", float(run.stdout) / size, MOST_MEMORY, False, note)
