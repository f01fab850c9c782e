"""Logs of every format cut off, or with a count too large, at every place of their headers: read, or one line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from recordings import read_recording
from recordings.readers import FileFormat
from scenarios.errors import InputError
from tests.fuzz.contract import DAILY_SHARE, amounts, answered
from tests.fuzz.material import log_table
from tests.recordings.readers.test_contract import example, formats

HEADER, END = 1024, 64
"""Bytes from the start and before the end of a file that hold a header or a footer."""
BIG = (b"\xff", b"\xff\xff\xff\x7f", b"\xff" * 8)
"""A byte, a 32-bit and a 64-bit count that no file of some kilobytes has."""


def places(length: int, times: int) -> list[int]:
    """Where a file is damaged: the first and last bytes more densely than others; in the nightly run each of them."""
    dense = 60 * DAILY_SHARE * (times == 1) + 1
    return sorted({*range(1, min(HEADER, length), dense), *range(max(length - END, 1), length, 1 + dense // 8)})


def damaged(whole: bytes, times: int) -> Iterator[tuple[str, bytes]]:
    """What was done, and the damaged content."""
    for k, at in enumerate(places(len(whole), times)):
        yield f"cut off at {at}", whole[:at]
        large = BIG[k % len(BIG)]
        yield f"{large.hex()} at {at}", whole[:at] + large + whole[at + len(large) :]


@amounts
@formats
def test_header_boundaries(form: FileFormat, tmp_path: Path, times: int) -> None:
    log = tmp_path / f"log{form.suffixes[0]}"
    for what, content in damaged(example(form.name, log.name), times):
        log.write_bytes(content)
        try:
            answered(lambda: read_recording(log))
        except Exception as error:
            error.add_note(what)
            raise


def test_a_ulog_whose_fields_have_other_names(tmp_path: Path) -> None:
    """Any one field, renamed by a damaged letter, is done without or named in the refusal."""
    log, refused = tmp_path / "log.ulg", 0
    whole = example("ULog", log.name)
    for old in (b"timestamp;", b" x;", b" z;", b"gyro_rad;", b"accelerometer_m_s2;", b"temperature;"):
        for at in (k for k in range(len(whole)) if whole.startswith(old, k)):
            log.write_bytes(whole[: at + len(old) - 2] + b"!" + whole[at + len(old) - 1 :])
            try:
                read_recording(log)
            except InputError as error:
                refused += "field" in str(error)
    assert refused > 0


def test_times_that_are_all_infinite(tmp_path: Path) -> None:
    """A file whose every time is infinite is refused without a warning."""
    table = log_table()
    infinite = table.set_column(table.column_names.index("time_s"), "time_s", pa.array(np.full(len(table), np.inf)))
    pq.write_table(infinite, tmp_path / "log.parquet")
    assert not answered(lambda: read_recording(tmp_path / "log.parquet"))
