"""Bounds of a comparison's runs, kept beside the trials: a repeated comparison computes those of new runs alone."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from recordings.files import canonical_json, system_errors_about, write_text
from validation.bound.ratio import LeastErrors
from validation.bound.runs import RunBounds
from validation.comparison.design import Design
from validation.comparison.sealed_lines import matches, sealed

BOUNDS = "bounds.jsonl"


@dataclass
class KeptBounds:
    """The file of bounds of a design's runs for a set of knowledges; a file of others is replaced.

    A line a run, sealed by a checksum; the first line is a digest of the design's identity and of the knowledges.
    """

    path: Path
    design: Design
    knowledges: frozenset[str]
    _known: dict[tuple[int, int], LeastErrors] = field(default_factory=dict, repr=False)

    def of(self, point: int, runs: Sequence[int]) -> list[LeastErrors]:
        """Return the bounds of runs at a point, in order; new bounds are added to the file."""
        if not self.knowledges:
            return [{} for _ in runs]
        self._known = self._known or self._read()
        missing = [run for run in runs if (point, run) not in self._known]
        bounds = RunBounds(self.design.points[point].scenario, self.design.seed, self.knowledges)
        with self._file() as lines:
            for run in missing:
                found = self._known[point, run] = bounds.of(run)
                lines.append(json.dumps({"point": point, "run": run, "least": [[*key, found[key]] for key in found]}))
        return [self._known[point, run] for run in runs]

    @contextmanager
    def _file(self) -> Iterator[list[str]]:
        """Yield a list whose texts are appended to the file, also where the block ends early."""
        lines: list[str] = []
        try:
            yield lines
        finally:
            if lines:
                with system_errors_about(self.path), self.path.open("ab") as file:
                    file.writelines(map(sealed, lines))

    def _read(self) -> dict[tuple[int, int], LeastErrors]:
        """Return the bounds in the file; begin the file anew where it is missing, or of another design."""
        identity = {"of": self.design.identity(), "knowledges": sorted(self.knowledges)}
        first = sealed(canonical_json({"bounds": hashlib.sha256(canonical_json(identity).encode()).hexdigest()}))
        with system_errors_about(self.path):
            lines = self.path.read_bytes().splitlines(keepends=True) if self.path.is_file() else []
        kept = [line for line in lines[1:] if matches(line)] if lines[:1] == [first] else []
        if lines != [first, *kept]:  # another design's, damaged, or torn by a kill
            write_text(self.path, b"".join([first, *kept]).decode())
        found = map(json.loads, kept)
        return {(one["point"], one["run"]): {(of, column): v for of, column, v in one["least"]} for one in found}
