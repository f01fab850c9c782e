"""A copy of the tree in which a file is changed, the tests are run, and the file is put back."""

from __future__ import annotations

import compileall
import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.mutants.changes import Mutant


@dataclass(frozen=True)
class Tree:
    """A copy of the tracked files."""

    root: Path

    @classmethod
    def copied(cls, original: Path, place: Path) -> Tree:
        """Copy what git tracks, as it stands in the working tree; compiled, so that runs start sooner."""
        names = subprocess.run(["git", "ls-files", "-z"], cwd=original, capture_output=True, text=True, check=True)
        tracked = [original / name for name in filter(None, names.stdout.split("\0"))]
        for file in (*tracked, *_compiled(tracked)):
            if file.is_file():
                copy = place / file.relative_to(original)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, copy)
        compileall.compile_dir(place, quiet=2)
        return cls(place)

    def text(self, path: str) -> str:
        """A file's text."""
        return (self.root / path).read_text(encoding="utf-8")

    @contextlib.contextmanager
    def changed(self, mutant: Mutant, kernels: Iterable[str] = ()) -> Iterator[None]:
        """The tree with the mistake in it; kernels: the files whose compiled loops may have it within.

        Compiled loops are kept by a digest of all sources that they depend on: what the tests compile with the mistake
        takes the place of what was compiled before, which is put back afterwards.
        """
        target, text = self.root / mutant.path, self.text(mutant.path)
        with _date_kept(target), _compiled_kept([self.root / path for path in kernels]):
            try:
                target.write_text(mutant.applied(text), encoding="utf-8")
                yield
            finally:
                target.write_text(text, encoding="utf-8")


@contextlib.contextmanager
def _date_kept(file: Path) -> Iterator[None]:
    date_ns = file.stat().st_mtime_ns
    try:
        yield
    finally:
        os.utime(file, ns=(date_ns, date_ns))


@contextlib.contextmanager
def _compiled_kept(users: Sequence[Path]) -> Iterator[None]:
    """Afterwards numba's files are those of before."""
    kept = {file: file.read_bytes() for file in _compiled(users)}
    try:
        yield
    finally:
        for file in _compiled(users):
            file.unlink()
        for file, content in kept.items():
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(content)


def _compiled(users: Iterable[Path]) -> list[Path]:
    """Numba's files, see scenarios/kernel_cache.py."""
    return [file for user in users for file in (user.parent / "__pycache__").glob(f"*.{user.stem}.*/*.nb[ci]")]
