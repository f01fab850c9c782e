"""List of the trials that a comparison's recordings show, so that a repeat makes no unchanged recording again."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recordings.files import canonical_json, sha256_of, system_errors_about, write_text
from validation.comparison.design import Design
from validation.comparison.sealed_lines import sealed

LISTED, RECORDINGS = "recordings.jsonl", "recordings"


@dataclass(frozen=True)
class KeptRecordings:
    """The recordings in a comparison's directory `out`, and beside them a sealed line with what they show.

    The line holds a digest of the design, the run of each recording, and each file's SHA-256: a recording of another
    design or run, or one that was changed, is not believed.
    """

    out: Path
    design: Design

    def show(self, runs: Mapping[str, int]) -> bool:
        """Return whether the files are the recordings of these runs, by name."""
        with system_errors_about(self.out):
            listed = self.out / LISTED
            there = listed.is_file() and all(self.file(name).is_file() for name in runs)
            return there and listed.read_bytes() == self._line(runs)

    def keep(self, runs: Mapping[str, int]) -> None:
        """List the files as the recordings of these runs."""
        with system_errors_about(self.out):
            write_text(self.out / LISTED, self._line(runs).decode())

    def file(self, name: str) -> Path:
        """Return the path of a recording."""
        return self.out / RECORDINGS / f"{name}.rrd"

    def _line(self, runs: Mapping[str, int]) -> bytes:
        design = hashlib.sha256(canonical_json(self.design.identity()).encode()).hexdigest()
        files: dict[str, Any] = {
            name: {"run": run, "sha256": sha256_of(self.file(name))} for name, run in sorted(runs.items())
        }
        return sealed(canonical_json({"design": design, "recordings": files}))
