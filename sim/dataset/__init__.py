"""Datasets on disk: columns, writing, resuming, reading, and the import of measured logs."""

from __future__ import annotations

from sim.dataset.columns import Column, columns, columns_of, schema
from sim.dataset.manifest import Manifest, read_manifest, run_path
from sim.dataset.metadata import RunFile, run_file, run_metadata
from sim.dataset.reader import read_recording, read_run
from sim.dataset.recording import Recording, Truth
from sim.dataset.resume import finish_dataset, open_dataset_for_writing
from sim.dataset.writer import RunWriter, write_recording

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
    "open_dataset_for_writing",
    "read_manifest",
    "read_recording",
    "read_run",
    "run_file",
    "run_metadata",
    "run_path",
    "schema",
    "write_recording",
]
