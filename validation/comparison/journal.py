"""Journal of completed trials, a JSON line each, from which an interrupted comparison or gate run resumes."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import pyarrow as pa

from recordings.files import atomic_write, canonical_json, system_errors_about, write_text
from recordings.resume import differences
from scenarios.errors import InputError
from validation.comparison.sealed_lines import matches, sealed, unsealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_columns import SCHEMA, columns_in, in_order
from validation.text import counted

JOURNAL = "journal.jsonl"
COMPARISON = "comparison"
KEY = re.compile(rb'\{"sha256":"\w+","point":(\d+),"run":(\d+),')
"""Begin of a trial's line."""
BLOCK_BYTES = 8 << 20
"""Text of a journal in memory at a time."""
ELSEWHERE = "choose another output directory, or remove this one"


@dataclass
class Journal:
    """Trials of a comparison or gate run in a directory; the first line of the file is the identity.

    Every line begins with a checksum of the rest. A line that does not match (torn, damaged, or of a release without
    checksums) is removed and the trial computed again, since design, seed and run determine a trial. The caller holds
    `locked_directory`.
    """

    path: Path
    there: set[tuple[int, int]] = field(default_factory=set)
    """(point, run) of every kept trial."""

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
        purpose, and for a damaged first line.
        """
        path = out / JOURNAL
        other = _difference(path, of, json.loads(canonical_json(identity))) if path.exists() else ""
        if other and not anew:
            raise InputError(f"holds another {of}: {other}", where=str(out), do=ELSEWHERE)
        if other or not path.exists():
            write_text(path, sealed(canonical_json({of: identity})).decode())
        journal = cls(path)
        with system_errors_about(path):
            removed = _remove_damaged_lines(path)
        if removed:
            warn(f"{path}: {counted(removed, 'line')} damaged or without a matching checksum; computed again")
        journal.there = set(_keys(path))
        return journal

    def add(self, trial: Trial) -> None:
        """Append a trial to the file."""
        with system_errors_about(self.path, "free some space; the same command resumes"), self.path.open("ab") as file:
            file.write(sealed(json.dumps(asdict(trial), separators=(",", ":"))))
        self.there.add((trial.point, trial.run))

    def remove(self) -> None:
        """Delete the file and all kept trials."""
        with system_errors_about(self.path):
            self.path.unlink()
        self.there.clear()

    def columns(self, runs: int) -> pa.Table:
        """Return the kept trials of the runs below `runs`, each once and in order, as a table of `SCHEMA`.

        Raises InputError for a line with a matching checksum that is no trial.
        """
        with system_errors_about(self.path):
            found = pa.concat_tables([SCHEMA.empty_table(), *map(columns_in, _blocks(self.path))])
        return in_order(found, runs)

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
        seen = set()
        with self.path.open("rb") as file:
            next(file)
            for line in file:
                trial = _read(line)
                if trial is not None and (trial.point, trial.run) not in seen:
                    seen.add((trial.point, trial.run))
                    yield trial


def _keys(path: Path) -> Iterator[tuple[int, int]]:
    """Yield (point, run) of every trial of a file without damaged lines, without reading the rest of the line."""
    with path.open("rb") as file:
        next(file)
        for line in file:
            found = KEY.match(line)
            if found:
                yield int(found[1]), int(found[2])


def _blocks(path: Path) -> Iterator[bytes]:
    """Yield the lines after the first that match their checksums, about BLOCK_BYTES at a time."""
    with path.open("rb") as file:
        next(file)
        while lines := file.readlines(BLOCK_BYTES):
            yield b"".join(line for line in lines if matches(line))


def _read(line: bytes) -> Trial | None:
    """Return the trial of a line, None for a line that does not match its checksum."""
    data = unsealed(line)
    if data is None:
        return None
    return Trial(data["point"], data["run"], tuple(TrialRow(**row) for row in data["rows"]))


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


def _remove_damaged_lines(path: Path) -> int:
    """Write the file again without the lines that do not match their checksum; return their number."""
    with path.open("rb") as file:
        first, *lines = file
    kept = [line for line in lines if matches(line)]
    if len(kept) < len(lines):
        with atomic_write(path) as part:
            part.write_bytes(b"".join([first, *kept]))
    return len(lines) - len(kept)
