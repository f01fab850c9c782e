"""Datasets on disk: columns, writing, resuming, reading, and the import of measured logs."""

from __future__ import annotations

from recordings.columns import Column, columns, columns_of, schema
from recordings.manifest import Manifest, read_manifest, run_path
from recordings.metadata import RunFile, run_file, run_metadata
from recordings.reader import read_recording, read_run
from recordings.recording import Recording, Truth
from recordings.resume import finish_dataset, open_dataset_for_writing
from recordings.writer import RunWriter, write_recording

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
