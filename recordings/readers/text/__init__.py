"""Text logs as people have them: tables in any dialect, with or without a header."""

from __future__ import annotations

from pathlib import Path

from recordings.readers.base import FileFormat
from recordings.readers.text.reading import is_table, read

_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".asc")
_SHARED = ".log"
"""A suffix of text that other formats list as theirs."""


def _recognises(path: Path, head: bytes) -> bool:
    return path.suffix.lower() in (*_SUFFIXES, _SHARED) or is_table(head)


TEXT = FileFormat(
    name="CSV",
    suffixes=_SUFFIXES,
    summary="a text table",
    remark="any table or print-out; exports of Xsens, VectorNav, SBG, DJI, MotionCal, GnssLogger",
    recognises=_recognises,
    read=read,
)
