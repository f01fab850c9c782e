"""Trials of a journal as Arrow columns in a file beside the journal, so that only new lines are read as text."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import pyarrow as pa

from recordings.files import system_errors_about
from validation.comparison.sealed_lines import sealed, unsealed
from validation.comparison.trial_columns import SCHEMA

KEPT_COLUMNS = "journal.columns"
NEAR_BYTES = 4096
"""Text before the end of the covered part that is compared with the journal."""
HEADER_BYTES = 1024
"""Longest header line of a part."""


@dataclass(frozen=True)
class JournalPart:
    """Header of a file's part: trials whose lines stand in the bytes `start` to `end` of the journal.

    near : SHA-256 of the journal's text before `end`. mtime_ns : the journal's time of change when the part was
    written. size, digest : bytes and SHA-256 of the columns that follow.
    """

    start: int
    end: int
    near: str
    mtime_ns: int
    size: int
    digest: str


@dataclass(frozen=True)
class KeptColumns:
    """A file of parts, each a sealed line of JSON and an Arrow stream; appended, never changed.

    The figures are those of the lines when they were read: damage to these lines afterwards changes no figure. The file
    is dropped, and the journal read again, where a checksum does not match, and where the journal was changed: shorter
    than the covered part, another text at its end, or another time of change without new lines.
    """

    path: Path

    def read(self, journal: Path) -> tuple[pa.Table, int]:
        """Return the kept trials in order of completion, and the end of their lines, without a file of the first line.

        Raises InputError where the operating system refuses.
        """
        with system_errors_about(journal), journal.open("rb") as file:
            begin = len(file.readline())
        with system_errors_about(self.path):
            found = list(self._parts(begin)) if self.path.is_file() else []
            if found and found[-1] is not None and _covers(found[-1][0], journal):
                whole = [one for one in found if one is not None]
                return pa.concat_tables([trials for _, trials in whole]), found[-1][0].end
        self.remove()
        return SCHEMA.empty_table(), begin

    def add(self, trials: pa.Table, journal: Path, start: int, end: int) -> None:
        """Append the trials of a part of the journal."""
        columns = _written(trials)
        with system_errors_about(self.path):
            changed_ns = journal.stat().st_mtime_ns
            part = JournalPart(start, end, _near(journal, end), changed_ns, columns.size, _digest(columns))
            with self.path.open("ab") as file:
                file.write(sealed(json.dumps({"part": asdict(part)})))
                file.write(columns)

    def remove(self) -> None:
        """Delete the file where there is one."""
        with system_errors_about(self.path):
            self.path.unlink(missing_ok=True)

    def _parts(self, begin: int) -> Iterator[tuple[JournalPart, pa.Table] | None]:
        """Yield header and trials of every part; None, and no more, for a part that is damaged or out of place.

        begin : bytes of the journal before the first trial.
        """
        with self.path.open("rb") as file:
            while line := file.readline(HEADER_BYTES):
                part = _header(line)
                trials = None if part is None else _trials(file.read(part.size), part.digest)
                if part is None or trials is None or part.start != begin:
                    yield None
                    return
                yield part, trials
                begin = part.end


def _header(line: bytes) -> JournalPart | None:
    """Return the part of a header line, None for a line that is none."""
    try:
        return JournalPart(**(unsealed(line) or {})["part"])
    except (KeyError, TypeError, ValueError):
        return None


def _trials(columns: bytes, digest: str) -> pa.Table | None:
    """Return the trials of an Arrow stream, None for damage and for another release's columns."""
    if _digest(columns) != digest:
        return None
    with pa.ipc.open_stream(columns) as stream:
        return stream.read_all() if stream.schema.equals(SCHEMA) else None


def _written(trials: pa.Table) -> pa.Buffer:
    """Return trials as an Arrow stream of one batch."""
    into = pa.BufferOutputStream()
    with pa.ipc.new_stream(into, SCHEMA, options=pa.ipc.IpcWriteOptions(compression="zstd")) as stream:
        stream.write_table(trials.combine_chunks())
    return into.getvalue()


def _covers(last: JournalPart, journal: Path) -> bool:
    """Return whether the journal is the one whose lines were read up to the end of the last part, or has grown."""
    there = journal.stat()
    grown = there.st_size > last.end
    same = there.st_size == last.end and there.st_mtime_ns == last.mtime_ns
    return (grown or same) and _near(journal, last.end) == last.near


def _near(journal: Path, end: int) -> str:
    start = max(end - NEAR_BYTES, 0)
    with journal.open("rb") as file:
        file.seek(start)
        return _digest(file.read(end - start))


def _digest(content: bytes | pa.Buffer) -> str:
    return hashlib.sha256(content).hexdigest()
