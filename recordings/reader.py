"""The way from a file, whoever wrote it, to a Recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from recordings.assemble import recording_of, truth_of
from recordings.checks import check_columns, check_field, check_truth
from recordings.importer import RawColumns, read_columns
from recordings.manifest import file_of
from recordings.mending import mended
from recordings.metadata import read_metadata
from recordings.readers import is_parquet
from recordings.reading import Reading, report
from recordings.recording import Recording, Truth


def read_recording(path: Path, *, run: int = 0, maps: Sequence[str] = (), reading: Reading | None = None) -> Recording:
    """Read a recording, without truth, from a run, a dataset directory (its run number `run`), or a measured log.

    All columns but time_s and mag_* are optional. Every further numeric column is a channel, further text is left out.
    reading : how the log is read, by default as kept beside it; maps : further `--map` texts.
    Checks and filled cells: `checks.check_columns`, `check_field`.
    Raises InputError with file, column and row for data that are not fit for use.

    >>> rows = [f"{0.1 * k:.1f},{20000 + k},{k},{43000 - k}" for k in range(20)]
    >>> size = Path("log.csv").write_text("\\n".join(["time_s,mag_x_nT,mag_y_nT,mag_z_nT", *rows]))
    >>> read_recording(Path("log.csv")).mag_nT[3].tolist()
    [20003.0, 3.0, 42997.0]
    """
    file = file_of(path, run)
    raw = read_columns(file, Reading.for_file(file, maps, reading))
    recording = checked_recording(raw)
    report(*recording.origin.notes)
    pa.default_memory_pool().release_unused()  # else Arrow keeps twice the memory of a long log
    return recording


def checked_recording(raw: RawColumns) -> Recording:
    """Return the recording in columns, mended and checked; InputError for data that are not fit for use."""
    whole = mended(raw)
    return recording_of(check_field(whole, check_columns(whole)), whole.origin)


def read_run(path: Path, *, run: int = 0) -> tuple[Recording, Truth]:
    """Read a simulated run with its truth, from its file or from a dataset directory.

    A run may be short, strange or without motion: `checks.check_field` is not applied.
    Raises InputError where the file holds no truth.

    >>> import magbench
    >>> import numpy as np
    >>> made = magbench.simulate("tumble", "data", overrides=["phases.0.duration_s=60"])
    >>> recording, truth = read_run(Path("data"))
    >>> bool(np.allclose(truth.field_nT + sum(truth.effects.values()), recording.mag_nT))
    True
    """
    file = file_of(path, run)
    raw = read_columns(file, wanted=lambda name: True)
    return recording_of(check_columns(raw)), truth_of(check_truth(raw), parameters_of(file))


def parameters_of(file: Path) -> dict[str, Any]:
    """Return the true parameters in a simulated run's file; empty for a measured log."""
    if file.is_dir() or not is_parquet(file):
        return {}
    return read_metadata(file).parameters.model_dump(exclude_unset=True)
