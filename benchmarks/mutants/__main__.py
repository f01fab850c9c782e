"""Random mutants of the program against the tests that cover each; JSON lines, resumed by the same command."""

from __future__ import annotations

import argparse
import json
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.mutants.aside import set_aside
from benchmarks.mutants.changes import Mutant, mutants
from benchmarks.mutants.covering import Cover, Imports, chosen
from benchmarks.mutants.observing import observed
from benchmarks.mutants.places import Source
from benchmarks.mutants.running import FOLDERS, Chosen, Run
from benchmarks.mutants.tree import Tree

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers")
DRAWINGS = ("reports/", "figures.py")
"""Where a number is a matter of taste."""
COMPILING_S = 240
"""Most CPU for compiling the loops that a mistake is in."""
SURVIVED = (0, 5)
"""By pytest's status: all passed, or none is left that could fail."""
TIMED_OUT = (-signal.SIGXCPU, -signal.SIGKILL)
Row = dict[str, Any]


def main() -> None:
    """Draw, run those that are not in the file yet, and count what became of them.

    killed: a test failed that passes on the program as it is; timed out: one took several times as long; survived:
    none did.
    """
    options = _options()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.touch()
    done = {row["key"]: row for row in map(json.loads, options.out.read_text().splitlines())}
    with tempfile.TemporaryDirectory() as place:
        record = options.out.with_suffix(".tests.jsonl")
        bench = Bench.of(Tree.copied(ROOT, Path(place)), record, options.most_cpu, options.rooms)
        drawn = bench.drawn(options.mutants, options.seed)
        for key, mutant in drawn.items():
            if key not in done or (options.again and done[key]["verdict"] == "survived"):
                done[key] = {"key": key} | bench.tried(mutant)
                with options.out.open("a") as file:
                    print(json.dumps(done[key]), file=file)
                print(f"{done[key]['verdict']:9}{done[key]['wall_s']:6.0f} s  {key}", file=sys.stderr, flush=True)
    print(summary(done[key] for key in drawn))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description=__doc__)
    parser.add_argument("--mutants", type=int, default=150, help="how many")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--most-cpu", type=float, default=75.0, help="most seconds of tests for a mutant")
    parser.add_argument("--rooms", nargs="*", default=(), help="folders such as validation/gates, by their own tests")
    parser.add_argument("--again", action="store_true", help="run survivors again, after a change of the tests")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/mutants.jsonl"), help="file of results")
    return parser.parse_args()


@dataclass(frozen=True)
class Bench:
    """A copy of the tree with what its tests cover; most_cpu_s: of the tests for one mutant; rooms: of the mutants."""

    tree: Tree
    cover: Cover
    most_cpu_s: float
    rooms: tuple[str, ...] = PACKAGES

    @classmethod
    def of(cls, tree: Tree, record: Path, most_cpu_s: float, rooms: Sequence[str] = ()) -> Bench:
        """With a record of which test runs what; what it lacks is run first. rooms: default all."""
        imports = Imports.read(tree.root, FOLDERS)
        sources = {path: Source(tree.text(path)) for path in imports.of if not path.startswith("tests/")}
        tested = tuple(f"tests/{room}/" for room in rooms) or ("tests/",)
        files = [path for path in imports.of if Path(path).name.startswith("test_") and path.startswith(tested)]
        seen = observed(tree.root, files, record)
        return cls(tree, Cover(sources, imports, seen), most_cpu_s, tuple(rooms) or PACKAGES)

    def drawn(self, count: int, seed: int) -> dict[str, Mutant]:
        """`count` mutants by key, all equally likely; more of them are the same ones and others."""
        inside = tuple(f"{room}/" for room in self.rooms)
        texts = {path: self.tree.text(path) for path in self.cover.sources if path.startswith(inside)}
        pool = [
            mutant
            for path, text in texts.items()
            for mutant in mutants(path, text, numbers=not any(part in path for part in DRAWINGS))
        ]
        random.Random(seed).shuffle(pool)
        return {mutant.key(texts[mutant.path]): mutant for mutant in pool[:count]}

    def tried(self, mutant: Mutant) -> Row:
        """What became of one."""
        start_s, seconds = time.monotonic(), self.cover.observed.seconds
        covering = self.cover.tests(mutant.path, mutant.line)
        tests = chosen(mutant.path, covering, seconds, self.most_cpu_s)
        kernels = self.cover.kernels(mutant.path, mutant.line)
        last = self.tree.root / ".last"
        last.write_text("")
        files = list(dict.fromkeys(test.split("::")[0] for test in tests))
        arguments = (tests, COMPILING_S if kernels else 0, last)
        with self.tree.changed(mutant, kernels):
            status = Run(self.tree.root, files, ("-x",), Chosen, arguments).status() if tests else 0
        verdict = "survived" if status in SURVIVED else "timed out" if status in TIMED_OUT else "killed"
        return {
            "verdict": verdict,
            "by": "" if verdict == "survived" else last.read_text(),
            "line": mutant.line,
            "kind": mutant.kind,
            "tests": len(tests),
            "left": len(covering - tests.keys()),
            "wall_s": round(time.monotonic() - start_s, 1),
        }


def summary(rows: Iterable[Row]) -> str:
    """How many were killed of those that are not set aside."""
    aside = set_aside()
    left, words = Counter[str](), Counter[str]()
    for row in rows:
        if row["verdict"] == "survived" and row["key"] in aside:
            words[aside[row["key"]]] += 1
        else:
            left[row["verdict"]] += 1
    killed, reasons = left["killed"] + left["timed out"], ", ".join(f"{count} {word}" for word, count in words.items())
    return f"killed {killed} of {left.total()} ({left['timed out']} of them timed out), {words.total()} set aside" + (
        f" ({reasons})" if words else ""
    )


if __name__ == "__main__":
    main()
