"""Trials kept as they land, a line each: what a killed comparison, or run of gates, resumes from."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from recordings.files import canonical_json, system_errors_about, write_text
from recordings.resume import differences
from scenarios.errors import InputError
from validation.comparison.trial import Trial, TrialRow

JOURNAL = "journal.jsonl"
COMPARISON = "comparison"
ELSEWHERE = "choose another output directory, or remove this one"


@dataclass
class Journal:
    """The trials of one comparison, or run of gates, in a directory; the first line of the file says which.

    A line that a killed process left torn, or that was damaged since, is a trial to be computed again: as its figures
    follow from design, seed and run nothing is lost. The caller holds `locked_directory`.
    """

    path: Path
    there: set[tuple[int, int]] = field(default_factory=set)
    """(point, run) of every trial that is kept."""

    @classmethod
    def open(cls, out: Path, identity: dict[str, Any], of: str = COMPARISON, *, anew: bool = False) -> Journal:
        """Begin, or go on with what is there.

        of : what the trials are for, one word for the first line. anew : where other trials of that kind are there they
        are dropped, not refused. Raises InputError for other trials, and for what is no journal of that kind.
        """
        path = out / JOURNAL
        other = _other(path, of, json.loads(canonical_json(identity))) if path.exists() else ""
        if other and not anew:
            raise InputError(f"holds another {of}: {other}", where=str(out), do=ELSEWHERE)
        if other or not path.exists():
            write_text(path, canonical_json({of: identity}) + "\n")
        journal = cls(path)
        with system_errors_about(path):
            _cut_torn_line(path)
        journal.there = {(trial.point, trial.run) for trial in journal}
        return journal

    def add(self, trial: Trial) -> None:
        """Keep a trial, whatever becomes of this process afterwards."""
        with system_errors_about(self.path, "free some space; the same command resumes"), self.path.open("ab") as file:
            file.write((json.dumps(_plain(trial), separators=(",", ":")) + "\n").encode())
        self.there.add((trial.point, trial.run))

    def remove(self) -> None:
        """Drop all that is kept, and the file."""
        with system_errors_about(self.path):
            self.path.unlink()
        self.there.clear()

    def __iter__(self) -> Iterator[Trial]:
        """Every trial that is kept, once, in the order in which they landed."""
        seen = set()
        with self.path.open("rb") as file:
            next(file)
            for line in file:
                trial = _read(line)
                if trial is not None and (trial.point, trial.run) not in seen:
                    seen.add((trial.point, trial.run))
                    yield trial


def _plain(trial: Trial) -> dict[str, Any]:
    return asdict(trial)


def _read(line: bytes) -> Trial | None:
    try:
        data = json.loads(line)
        return Trial(data["point"], data["run"], tuple(TrialRow(**row) for row in data["rows"]))
    except (ValueError, KeyError, TypeError):
        return None


def _other(path: Path, of: str, identity: dict[str, Any]) -> str:
    """Where the journal that is there is of another identity, in words; InputError where it is of another kind."""
    with path.open("rb") as file:
        try:
            there = json.loads(next(file))[of]
        except (ValueError, KeyError, TypeError, StopIteration):
            raise InputError(f"is no journal of a {of}", where=str(path), do=ELSEWHERE) from None
    return differences(of, there, identity)


def _cut_torn_line(path: Path) -> None:
    """Cut what a killed process left after the last whole line."""
    with path.open("rb+") as file:
        end = file.seek(0, os.SEEK_END)
        while end and _byte_before(file, end) != b"\n":
            end -= 1
        file.truncate(end)


def _byte_before(file: Any, end: int) -> bytes:
    file.seek(end - 1)
    byte: bytes = file.read(1)
    return byte
