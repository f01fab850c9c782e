"""Trials kept as they land, a line each: what a killed comparison resumes from."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from scenarios.errors import InputError
from sim.dataset.files import canonical_json, system_errors_about, write_text
from sim.dataset.resume import differences
from validation.comparison.trial import Row, Trial

JOURNAL = "journal.jsonl"
ELSEWHERE = "choose another output directory, or remove this one"


@dataclass
class Journal:
    """The trials of one comparison in a directory; the first line of the file says which.

    A line that a killed process left torn, or that was damaged since, is a trial to be computed again: as its figures
    follow from design, seed and run nothing is lost. The caller holds `locked_directory`.
    """

    path: Path
    there: set[tuple[int, int]] = field(default_factory=set)
    """(point, run) of every trial that is kept."""

    @classmethod
    def open(cls, out: Path, identity: dict[str, Any]) -> Journal:
        """Begin a comparison, or go on with the one that is there; InputError where that is another."""
        path = out / JOURNAL
        if not path.exists():
            write_text(path, canonical_json({"comparison": identity}) + "\n")
        journal = cls(path)
        _refuse_another(path, json.loads(canonical_json(identity)))
        with system_errors_about(path):
            _cut_torn_line(path)
        journal.there = {(trial.point, trial.run) for trial in journal}
        return journal

    def add(self, trial: Trial) -> None:
        """Keep a trial, whatever becomes of this process afterwards."""
        with system_errors_about(self.path, "free some space; the same command resumes"), self.path.open("ab") as file:
            file.write((json.dumps(_plain(trial), separators=(",", ":")) + "\n").encode())
        self.there.add((trial.point, trial.run))

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
        return Trial(data["point"], data["run"], tuple(Row(**row) for row in data["rows"]))
    except (ValueError, KeyError, TypeError):
        return None


def _refuse_another(path: Path, identity: dict[str, Any]) -> None:
    with path.open("rb") as file:
        try:
            there = json.loads(next(file))["comparison"]
        except (ValueError, KeyError, TypeError, StopIteration):
            raise InputError("is no journal of a comparison", where=str(path), do=ELSEWHERE) from None
    found = differences("comparison", there, identity)
    if found:
        raise InputError(f"holds another comparison: {found}", where=str(path.parent), do=ELSEWHERE)


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
