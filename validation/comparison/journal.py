"""Journal of completed trials, a JSON line each, from which an interrupted comparison or gate run resumes."""

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
    """Trials of a comparison or gate run in a directory; the first line of the file is the identity.

    Torn or damaged lines are ignored and the trials computed again, since design, seed and run determine a trial. The
    caller holds `locked_directory`.
    """

    path: Path
    there: set[tuple[int, int]] = field(default_factory=set)
    """(point, run) of every kept trial."""

    @classmethod
    def open(cls, out: Path, identity: dict[str, Any], of: str = COMPARISON, *, anew: bool = False) -> Journal:
        """Start a journal, or continue the existing journal of an equal identity.

        of : purpose of the trials, the key of the first line. anew : drop a journal of a different identity instead of
        refusing. Raises InputError for a journal of a different identity or purpose.
        """
        path = out / JOURNAL
        other = _difference(path, of, json.loads(canonical_json(identity))) if path.exists() else ""
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
        """Append a trial to the file."""
        with system_errors_about(self.path, "free some space; the same command resumes"), self.path.open("ab") as file:
            file.write((json.dumps(asdict(trial), separators=(",", ":")) + "\n").encode())
        self.there.add((trial.point, trial.run))

    def remove(self) -> None:
        """Delete the file and all kept trials."""
        with system_errors_about(self.path):
            self.path.unlink()
        self.there.clear()

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


def _read(line: bytes) -> Trial | None:
    try:
        data = json.loads(line)
        return Trial(data["point"], data["run"], tuple(TrialRow(**row) for row in data["rows"]))
    except (ValueError, KeyError, TypeError):
        return None


def _difference(path: Path, of: str, identity: dict[str, Any]) -> str:
    """Return the differences to the identity of an existing journal; InputError for a different purpose."""
    with path.open("rb") as file:
        try:
            existing = json.loads(next(file))[of]
        except (ValueError, KeyError, TypeError, StopIteration):
            raise InputError(f"is no journal of a {of}", where=str(path), do=ELSEWHERE) from None
    return differences(of, existing, identity)


def _cut_torn_line(path: Path) -> None:
    """Truncate the file after the last complete line."""
    with path.open("rb+") as file:
        end = file.seek(0, os.SEEK_END)
        while end and _byte_before(file, end) != b"\n":
            end -= 1
        file.truncate(end)


def _byte_before(file: Any, end: int) -> bytes:
    file.seek(end - 1)
    byte: bytes = file.read(1)
    return byte
