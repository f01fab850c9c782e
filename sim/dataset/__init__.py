"""Datasets on disk: columns, writing, resuming, reading, and the import of measured logs."""

from __future__ import annotations

from sim.dataset.columns import Column, columns, columns_of, schema
from sim.dataset.importer import read_measured
from sim.dataset.manifest import (
    Manifest,
    finish_dataset,
    open_dataset_for_writing,
    read_manifest,
    run_metadata,
    run_path,
)
from sim.dataset.reader import iter_blocks, read_recording, read_run
from sim.dataset.recording import Recording, Truth
from sim.dataset.writer import RunFile, RunWriter, run_file, write_recording

__all__ = [
    "Column",
    "Manifest",
    "Recording",
    "RunFile",
    "RunWriter",
    "Truth",
    "columns",
    "columns_of",
    "finish_dataset",
    "iter_blocks",
    "open_dataset_for_writing",
    "read_manifest",
    "read_measured",
    "read_recording",
    "read_run",
    "run_file",
    "run_metadata",
    "run_path",
    "schema",
    "write_recording",
]
