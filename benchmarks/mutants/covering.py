"""Which tests are to notice a mistake in a line: those that run it, else those that run what uses its names."""

from __future__ import annotations

import ast
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.mutants.observing import Observed, file_of
from benchmarks.mutants.places import Place, Source


@dataclass(frozen=True)
class Imports:
    """Who imports whom in a tree, by path from its root."""

    of: Mapping[str, frozenset[str]]

    @classmethod
    def read(cls, root: Path, folders: Iterable[str]) -> Imports:
        """The imports that the files of some folders name, those in functions too."""
        paths = [p for folder in folders for p in sorted((root / folder).rglob("*.py"))]
        known = {str(p.relative_to(root)) for p in paths}
        return cls({str(p.relative_to(root)): frozenset(_imported(p, known)) for p in paths})

    def users(self, path: str) -> dict[str, int]:
        """Every file that imports this one, with the number of steps between them."""
        steps, queue = {path: 0}, deque([path])
        while queue:
            here = queue.popleft()
            for user, used in self.of.items():
                if here in used and user not in steps:
                    steps[user] = steps[here] + 1
                    queue.append(user)
        return steps


def _imported(path: Path, known: set[str]) -> Iterable[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            place = name.replace(".", "/")
            yield from ({f"{place}.py", f"{place}/__init__.py"} & known)


@dataclass(frozen=True)
class Cover:
    """The sources of a tree by path, who imports whom, and what its tests were seen to run."""

    sources: Mapping[str, Source]
    imports: Imports
    observed: Observed

    def tests(self, path: str, line: int) -> set[str]:
        """The tests that run a line.

        What runs without being seen, compiled or when the file is imported, has those of the file's mirror and of the
        lines that use its names; a line that nothing reaches has those that run anything of its file.
        """
        place = self.sources[path].place(line)
        seen = self._running(path, place)
        if seen:
            return seen
        mirrored = {test for test in self.observed.seconds if is_mirror(file_of(test), path)}
        return mirrored | self._by_name(path, place, set()) or self.observed.running(path)

    def kernels(self, path: str, line: int) -> list[str]:
        """The files with compiled functions that a mistake in a line may be compiled into."""
        place = self.sources[path].place(line)
        reached = self.imports.users(path) if place.kernel or not place.called else [path]
        return [user for user in reached if user in self.sources and self.sources[user].has_kernels]

    def _running(self, path: str, place: Place) -> set[str]:
        return self.observed.running(path, place.lines) if place.called else set()

    def _by_name(self, path: str, place: Place, done: set[tuple[str, int]]) -> set[str]:
        tests = self.observed.running(path, place.around)
        for user, line in self._uses(path, place):
            if (user, line) not in done:
                done.add((user, line))
                there = self.sources[user].place(line)
                tests |= self._running(user, there) or self._by_name(user, there, done)
        return tests

    def _uses(self, path: str, place: Place) -> Iterator[tuple[str, int]]:
        """Lines in the file itself, and in those that import it, which use the names of a place."""
        for user in [path, *(user for user, used in self.imports.of.items() if path in used)]:
            if user in self.sources:
                for name in place.names:
                    yield from ((user, line) for line in self.sources[user].uses.get(name, ()))


def chosen(path: str, tests: Iterable[str], seconds: Mapping[str, float], most_s: float) -> dict[str, float]:
    """Tests that take no longer than `most_s` together, with their seconds, in the order in which to run them.

    The mirror's come first, then the fastest, and after those given the others of their files: what a test file
    prepares once is seen in the first test alone. A file's tests run in one go, for the same reason.
    """
    given = set(tests)
    files = {file_of(test) for test in given}

    def order(test: str) -> tuple[bool, bool, float]:
        return test not in given, not is_mirror(file_of(test), path), seconds[test]

    within: dict[str, dict[str, float]] = defaultdict(dict)
    total_s = 0.0
    for test in sorted((test for test in seconds if file_of(test) in files), key=order):
        if total_s + seconds[test] <= most_s or not within:
            total_s += seconds[test]
            within[file_of(test)][test] = seconds[test]
    by_file = sorted(within, key=lambda file: (not is_mirror(file, path), sum(within[file].values())))
    return {test: s for file in by_file for test, s in within[file].items()}


def is_mirror(test_file: str, path: str) -> bool:
    """Whether a file of tests has the source's name in the same place below `tests`."""
    inside = Path(test_file).relative_to("tests")
    return inside.stem == f"test_{Path(path).stem}" and inside.parent in Path(path).parents
