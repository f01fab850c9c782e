"""Journal of completed trials, a JSON line each, from which an interrupted comparison or gate run resumes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import pyarrow as pa

from recordings.files import atomic_write, canonical_json, system_errors_about, write_text
from recordings.resume import differences
from scenarios.errors import InputError
from validation.comparison.kept_columns import KEPT_COLUMNS, KeptColumns
from validation.comparison.sealed_lines import matches, sealed
from validation.comparison.trial import Trial
from validation.comparison.trial_columns import SCHEMA, columns_in, in_order, trials_in
from validation.text import counted

JOURNAL = "journal.jsonl"
COMPARISON = "comparison"
BLOCK_BYTES = 8 << 20
"""Text of a journal in memory at a time."""
TRIALS_AT_A_TIME = 100
"""Trials that are objects in memory at a time."""
ELSEWHERE = "choose another output directory, or remove this one"


@dataclass
class Journal:
    """Trials of a comparison or gate run in a directory; the first line of the file is the identity.

    Every line begins with a checksum of the rest. A line that does not match (torn, damaged, or of a release without
    checksums) is removed and the trial computed again, since design, seed and run determine a trial. Each line is read
    once: `KeptColumns` beside the file holds the trials of the lines that a process before this one has read. The
    caller holds `locked_directory`.
    """

    path: Path
    there: set[tuple[int, int]] = field(default_factory=set)
    """(point, run) of every kept trial."""
    _trials: pa.Table = field(default_factory=SCHEMA.empty_table, repr=False)
    """Trials of the lines that were read, in order of completion."""
    _end: int = 0
    """Bytes of the file that were read."""
    _kept: tuple[int, int] = (0, 0)
    """Trials and bytes of these that `KeptColumns` holds."""

    @classmethod
    def open(
        cls,
        out: Path,
        identity: dict[str, Any],
        of: str = COMPARISON,
        *,
        anew: bool = False,
        warn: Callable[[str], object] = lambda text: None,
    ) -> Journal:
        """Start a journal, or continue the existing journal of an equal identity.

        of : purpose of the trials, the key of the first line. anew : drop a journal of a different identity instead of
        refusing. warn : gets a message about removed lines. Raises InputError for a journal of a different identity or
        purpose, for a damaged first line, and for a line with a matching checksum that is no trial.
        """
        path = out / JOURNAL
        other = _difference(path, of, json.loads(canonical_json(identity))) if path.exists() else ""
        if other and not anew:
            raise InputError(f"holds another {of}: {other}", where=str(out), do=ELSEWHERE)
        journal = cls(path)
        if other or not path.exists():
            journal.columns_file.remove()
            write_text(path, sealed(canonical_json({of: identity})).decode())
        removed = journal._read()
        if removed:
            warn(f"{path}: {counted(removed, 'line')} damaged or without a matching checksum; computed again")
        point, run = (journal._trials.column(name).to_pylist() for name in ("point", "run"))
        journal.there = set(zip(point, run, strict=True))
        return journal

    @property
    def columns_file(self) -> KeptColumns:
        """The trials that were read, beside the file."""
        return KeptColumns(self.path.with_name(KEPT_COLUMNS))

    def add(self, trial: Trial) -> None:
        """Append a trial to the file."""
        with system_errors_about(self.path, "free some space; the same command resumes"), self.path.open("ab") as file:
            file.write(sealed(json.dumps(asdict(trial), separators=(",", ":"))))
        self.there.add((trial.point, trial.run))

    def remove(self) -> None:
        """Delete the file and all kept trials."""
        self.columns_file.remove()
        with system_errors_about(self.path):
            self.path.unlink()
        self.there.clear()

    def columns(self, runs: int) -> pa.Table:
        """Return the kept trials of the runs below `runs`, each once and in order, as a table of `SCHEMA`.

        Raises InputError for a line with a matching checksum that is no trial.
        """
        self._read_on()
        trials, end = self._kept
        if self._end > end:
            self.columns_file.add(self._trials.slice(trials), self.path, end, self._end)
            self._kept = len(self._trials), self._end
        return in_order(self._trials, runs)

    @contextmanager
    def left_where_begun(self) -> Iterator[None]:
        """Within, an InputError before the first kept trial removes the file: a refusal leaves nothing behind."""
        try:
            yield
        except InputError:
            if not self.there:
                self.remove()
            raise

    def __iter__(self) -> Iterator[Trial]:
        """Yield every kept trial once, in order of completion."""
        self._read_on()
        seen = set()
        for first in range(0, len(self._trials), TRIALS_AT_A_TIME):
            for trial in trials_in(self._trials.slice(first, TRIALS_AT_A_TIME)):
                if (trial.point, trial.run) not in seen:
                    seen.add((trial.point, trial.run))
                    yield trial

    def _read(self) -> int:
        """Read all trials, from `KeptColumns` as far as they are there; remove damaged lines, return their number."""
        with system_errors_about(self.path):
            self._trials, self._end = self.columns_file.read(self.path)
            self._kept = len(self._trials), self._end
            start, removed = self._end, self._read_on()
            if removed:
                self._end = _remove_damaged_lines(self.path, start)
        return removed

    def _read_on(self) -> int:
        """Read the trials of the lines after those that were read; return the number of lines that are damaged."""
        damaged = 0
        with system_errors_about(self.path), self.path.open("rb") as file:
            file.seek(self._end)
            while lines := file.readlines(BLOCK_BYTES):
                whole = [line for line in lines if matches(line)]
                damaged += len(lines) - len(whole)
                self._trials = pa.concat_tables([self._trials, columns_in(b"".join(whole))])
            self._end = file.tell()
        return damaged


def _difference(path: Path, of: str, identity: dict[str, Any]) -> str:
    """Return the differences to the identity of an existing journal; InputError for a different purpose."""
    with path.open("rb") as file:
        line = file.readline()
    other = InputError(f"is no journal of a {of}, or its first line is damaged", where=str(path), do=ELSEWHERE)
    if not matches(line) and not line.startswith(f'{{"{of}"'.encode()):  # of a release without checksums
        raise other
    try:
        existing = json.loads(line)[of]
        return differences(of, existing, identity)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise other from None


def _remove_damaged_lines(path: Path, start: int) -> int:
    """Write the file again without the lines past `start` that do not match their checksum; return its length."""
    with path.open("rb") as file, atomic_write(path) as part, part.open("wb") as into:
        into.write(file.read(start))
        into.writelines(line for line in file if matches(line))
        return into.tell()
