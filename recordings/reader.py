"""Reading: the one way from a file, whoever wrote it, to a Recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from recordings.assemble import recording_of, truth_of
from recordings.checks import plausible, sound, whole_truth
from recordings.importer import read_columns
from recordings.manifest import file_of
from recordings.metadata import read_metadata
from recordings.readers import is_parquet
from recordings.recording import Recording, Truth


def read_recording(path: Path, *, run: int = 0, maps: Sequence[str] = ()) -> Recording:
    """Read what an instrument gives, never the truth: from a run, a dataset directory (its `run`), or a measured log.

    All columns but time_s and mag_* are optional. Any other numeric column is a channel, other text is left out.
    maps : `--map` texts, see `importer.read_columns`. What is checked and filled: `checks.sound`, `checks.plausible`.
    Raises InputError with file, column and row for everything that is not fit for use.
    """
    raw = read_columns(file_of(path, run), maps)
    recording = recording_of(plausible(raw.path, sound(raw)))
    pa.default_memory_pool().release_unused()  # twice what a long log takes would stay with Arrow
    return recording


def read_run(path: Path, *, run: int = 0) -> tuple[Recording, Truth]:
    """Read a simulated run with its truth, from its file or from a dataset directory.

    A run may be short, strange or without motion; whether its field is `plausible` is asked by who calibrates it.
    Raises InputError where the file holds no truth.
    """
    file = file_of(path, run)
    raw = read_columns(file, wanted=lambda name: True)
    return recording_of(sound(raw)), truth_of(whole_truth(raw), parameters_of(file))


def parameters_of(file: Path) -> dict[str, Any]:
    """The true parameters that a simulated run's file tells of; empty for a measured log."""
    return read_metadata(file).parameters.model_dump(exclude_unset=True) if is_parquet(file) else {}
