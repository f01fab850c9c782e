"""Random mutants of the program against the tests that cover each; JSON lines, resumed by the same command."""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.mutants.changes import Mutant, mutants
from benchmarks.mutants.covering import covering
from benchmarks.mutants.tree import Told, Tree

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("sim", "calib", "validation")
DRAWINGS = ("validation/views/", "figures.py")
"""Where a number is a matter of taste."""
FAILURE = (1, 2)
"""Statuses of pytest: a test failed, a test file could not be read."""


def main() -> None:
    """Draw, run those that are not in the file yet, and count what became of them.

    killed: a test failed that passes on the program as it is; survived: none did; ended: none had failed when the time
    was over, which a loop without end explains as well as tests that take long.
    """
    options = _options()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.touch()
    rows: list[dict[str, Any]] = [json.loads(line) for line in options.out.read_text().splitlines()]
    with tempfile.TemporaryDirectory() as place:
        bench = Bench(Tree.copied(ROOT, Path(place), options.most_cpu), options.files)
        known = {row["key"] for row in rows}
        for mutant in drawn(bench.tree, options.mutants, options.seed):
            if mutant.key not in known:
                rows.append(bench.tried(mutant))
                with options.out.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
                _say(rows[-1])
    counts = Counter(row["verdict"] for row in rows)
    print(", ".join(f"{verdict} {count}" for verdict, count in counts.most_common()), f"of {len(rows)} mutants")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description=__doc__)
    parser.add_argument("--mutants", type=int, default=150, help="how many")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--files", type=int, default=8, help="most files of tests for a mutant")
    parser.add_argument("--most-cpu", type=int, default=240, help="most seconds for a mutant")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/mutants.jsonl"), help="file of results")
    return parser.parse_args()


def drawn(tree: Tree, count: int, seed: int) -> list[Mutant]:
    """`count` mutants, all equally likely; more of them are the same ones and others."""
    paths = [path for path in tree.imports.of if path.split("/")[0] in PACKAGES]
    pool = [
        mutant
        for path in paths
        for mutant in mutants(path, tree.text(path), numbers=not any(part in path for part in DRAWINGS))
    ]
    random.Random(seed).shuffle(pool)
    return pool[:count]


class Bench:
    """Runs mutants; a test that fails without a mistake too is left out from then on."""

    def __init__(self, tree: Tree, files: int) -> None:
        self.tree, self.files = tree, files
        self.sound, self.failing = set[str](), list[str]()

    def tried(self, mutant: Mutant) -> dict[str, Any]:
        """What became of one."""
        tests = covering(mutant.path, self.tree.imports, self.files)
        with self.tree.changed(mutant):
            told = self.tree.run(tests, self.failing)
        if told.status in FAILURE and not self._is_sound(told.failed):
            return self.tried(mutant)
        verdict = "survived" if told.status == 0 else "killed" if told.status in FAILURE else "ended"
        return asdict(mutant) | self._story(mutant, told) | {"key": mutant.key, "verdict": verdict}

    def _is_sound(self, test: str) -> bool:
        """Whether a test passes on the program as it is."""
        if test not in self.sound:
            if self.tree.run([test]).status:
                self.failing.append(test)
                return False
            self.sound.add(test)
        return True

    def _story(self, mutant: Mutant, told: Told) -> dict[str, Any]:
        line = self.tree.text(mutant.path).splitlines()[mutant.line - 1].strip()
        return {"by": told.failed, "source": line, "wall_s": round(told.wall_s, 1), "status": told.status}


def _say(row: dict[str, Any]) -> None:
    change = f"{row['path']}:{row['line']}: {row['before']} -> {row['after']}: {row['source']}"
    print(f"{row['verdict']:9}{row['wall_s']:6.0f} s  {change}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
