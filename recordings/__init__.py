"""Recordings: what an instrument gives, whoever wrote it.

Reading: a file of any format in `readers.FORMATS`, or data in memory, becomes a Recording: columns in units, every
value checked. `streams` brings the streams of a log to the magnetometer's times.
Writing: runs as Parquet, datasets with a manifest, whole or not at all.
A simulated run holds recording and Truth in one file; as types the two are separate.
"""

from __future__ import annotations

from recordings.columns import Column, columns, columns_of, schema
from recordings.manifest import Manifest, read_manifest, run_path
from recordings.metadata import RunFile, run_file, run_metadata
from recordings.reader import read_recording, read_run
from recordings.readers import FORMATS, FileContents, FileFormat
from recordings.reading import Reading
from recordings.recording import Origin, Recording, Truth
from recordings.resume import finish_dataset, open_dataset_for_writing
from recordings.streams import Interpolation, MergedStreams, Stream, merge
from recordings.writer import RunWriter, write_recording

__all__ = [
    "FORMATS",
    "Column",
    "FileContents",
    "FileFormat",
    "Interpolation",
    "Manifest",
    "MergedStreams",
    "Origin",
    "Reading",
    "Recording",
    "RunFile",
    "RunWriter",
    "Stream",
    "Truth",
    "columns",
    "columns_of",
    "finish_dataset",
    "merge",
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
