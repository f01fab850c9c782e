"""Which test runs which lines, and how long each takes: every test once, under coverage, a folder at a time."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coverage
import pytest

from benchmarks.mutants.running import FOLDERS, Run

Row = dict[str, Any]
SOURCES = tuple(f"{room}/*" for room in ("recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers"))


class Observer:
    """A plugin of pytest: writes the CPU seconds of each test that passes and the lines of the program that it runs."""

    def __init__(self, out: Path) -> None:
        self.out, self.seconds, self.unfit = out, dict[str, float](), set[str]()
        self.coverage = coverage.Coverage(data_file=None, config_file=False, include=SOURCES, messages=False)
        self.coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """What prepares a test counts as a part of it."""
        self.coverage.switch_context(item.nodeid)
        start_s = _cpu_s()
        result = yield
        self.seconds[item.nodeid] = round(_cpu_s() - start_s, 3)
        self.coverage.switch_context("")
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """One that fails or is skipped here can notice nothing."""
        if not report.passed:
            self.unfit.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        """By file of tests."""
        self.coverage.stop()
        lines: dict[str, dict[str, list[int]]] = defaultdict(dict)
        data = self.coverage.get_data()
        for path in sorted(data.measured_files()):
            for line, tests in data.contexts_by_lineno(path).items():
                for test in tests:
                    lines[test].setdefault(str(Path(path).relative_to(Path.cwd())), []).append(line)
        by_file: dict[str, Row] = defaultdict(dict)
        for test in self.seconds.keys() - self.unfit:
            by_file[file_of(test)][test] = {"seconds": self.seconds[test], "lines": lines[test]}
        self.out.write_text(json.dumps(by_file))


def file_of(test: str) -> str:
    """The file that a test is in."""
    return test.split("::")[0]


def _cpu_s() -> float:
    """Of this process and of those that it started and that have ended."""
    return sum(os.times()[:4])


@dataclass(frozen=True)
class Observed:
    """CPU seconds of every test that passes, and by file and line the tests that run it."""

    seconds: dict[str, float]
    lines: dict[str, dict[int, set[str]]]

    @classmethod
    def of(cls, rows: Iterable[Row]) -> Observed:
        """Of several files of tests."""
        tests = {test: seen for row in rows for test, seen in row["tests"].items()}
        running: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
        for test, seen in tests.items():
            for path, lines in seen["lines"].items():
                for line in lines:
                    running[path][line].add(test)
        return cls({test: seen["seconds"] for test, seen in tests.items()}, running)

    def running(self, path: str, lines: Iterable[int] | None = None) -> set[str]:
        """The tests that run any of some lines, or of the whole file."""
        known = self.lines.get(path, {})
        return set[str]().union(*(known.get(line, ()) for line in (known if lines is None else lines)))


def observed(root: Path, files: Iterable[str], record: Path) -> Observed:
    """Run the files of tests that the record does not have, and read it.

    A row holds for the program, and for the file of tests, that it was made from.
    """
    program = _digest(path for folder in FOLDERS for path in (root / folder).rglob("*.py") if not _is_tests(path))
    wanted = {file: f"{file} {_digest([root / file])} {program}" for file in files}
    record.touch()
    rows = [row for row in map(json.loads, record.read_text().splitlines()) if row["of"] in wanted.values()]
    known = {row["of"] for row in rows}
    missing = [file for file, of in wanted.items() if of not in known]
    with record.open("w") as kept:
        kept.writelines(f"{json.dumps(row)}\n" for row in rows)
        for _, together in itertools.groupby(sorted(missing, key=_rooms_first), key=os.path.dirname):
            for file, tests in _seen(root, list(together)).items():
                rows.append({"of": wanted[file], "tests": tests})
                print(json.dumps(rows[-1]), file=kept, flush=True)
    return Observed.of(rows)


def _seen(root: Path, files: Sequence[str]) -> dict[str, Row]:
    """By file what its tests run, nothing where none passes."""
    out = root / ".observed"
    out.unlink(missing_ok=True)
    Run(root, files, ("--continue-on-collection-errors",), Observer, (out,)).status()
    by_file: dict[str, Row] = json.loads(out.read_text()) if out.exists() else {}
    print(
        f"observed {sum(map(len, by_file.values()))} tests of {os.path.dirname(files[0])}", file=sys.stderr, flush=True
    )
    return {file: by_file.get(file, {}) for file in files}


def _rooms_first(file: str) -> tuple[bool, str]:
    """The tests of the program's own rooms, by folder, before those of all together."""
    return not os.path.dirname(file).startswith(("tests/sim", "tests/calib", "tests/validation")), file


def _is_tests(path: Path) -> bool:
    return path.name.startswith("test_")


def _digest(paths: Iterable[Path]) -> str:
    together = hashlib.sha256()
    for path in sorted(paths):
        together.update(path.read_bytes())
    return together.hexdigest()[:16]
