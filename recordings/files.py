"""Files that appear whole or not at all, and directories that one process writes at a time."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any
from uuid import uuid4

from recordings.locks import ON_WINDOWS, lock
from recordings.url_path import Place
from scenarios.errors import InputError
from scenarios.plain import plain

PART = ".magbench-part"
"""The end of the name of a file that is being written."""
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Refuses a symlink at the name of a file that is being written; Windows has no such flag."""
READ_BYTES = 1 << 20
"""Bytes of a file in memory at a time."""
WAIT = "wait for it to end, or choose another output"


@contextmanager
def atomic_write(path: Place, shared: bool = False) -> Iterator[Path]:
    """Yield the file to write; flushed to disk and renamed to `path` when the block succeeds, removed when it fails.

    shared : whether several processes may write the same bytes to `path` at a time, each in a file of its own.
    Raises InputError where the operating system refuses, and unless shared where another process writes the same file.
    """
    if not isinstance(path, Path):
        with system_errors_about(path), path.replaced(PART) as part:
            yield part
        return
    part = path.with_name(f"{path.name}.{uuid4().hex}{PART}" if shared else path.name + PART)
    held = InputError("another magbench is writing this file", where=str(path), do=WAIT)
    with system_errors_about(path):
        descriptor = lock(part, os.O_RDWR | os.O_CREAT | NO_LINK, held)
    try:
        yield part
        with system_errors_about(path):
            _flush(part)
            os.replace(part, path)
    except BaseException:
        with system_errors_about(path):
            part.unlink(missing_ok=True)
        raise
    finally:
        os.close(descriptor)
    with system_errors_about(path):
        _flush(path.parent)


@contextmanager
def system_errors_about(
    path: Place, do: str = "free some space, or choose a directory that can be written"
) -> Iterator[None]:
    """Turn errors of the operating system (disk full, no permission, no such file) into an InputError about `path`."""
    try:
        yield
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error).splitlines()[0]
        raise InputError(reason[0].lower() + reason[1:], where=str(path), do=do) from error


@contextmanager
def locked_directory(out: Place) -> Iterator[None]:
    """Make a directory and keep other magbench processes out; the lock ends with the process and leaves no file.

    A file system without locks goes without. A directory that was made here and stayed empty is removed again.
    Raises InputError where the directory cannot be made, and where another process holds the lock.
    """
    if not isinstance(out, Path):
        yield  # object stores have no locks, and a file there appears whole
        return
    made = not out.exists()
    held = InputError("another magbench is writing here", where=str(out), do=WAIT)
    with system_errors_about(out, "choose another output directory"):
        descriptor = lock(out, os.O_RDONLY, held, lambda: out.mkdir(parents=True, exist_ok=True))
    try:
        yield
    finally:
        if made:
            with suppress(OSError):  # not empty
                out.rmdir()
        os.close(descriptor)


def remove_leftovers(out: Place) -> None:
    """Remove the half-written files of killed processes from a directory; InputError where that is refused."""
    for leftover in out.glob(f"*{PART}"):
        with system_errors_about(leftover):
            leftover.unlink()


def write_text(path: Place, text: str) -> None:
    """Write a text file whole or not at all."""
    with atomic_write(path) as part, system_errors_about(path):
        part.write_text(text, encoding="utf-8", newline="\n")


def sha256_of(path: Place) -> str:
    """Return the SHA-256 of a file, hexadecimal."""
    with path.open("rb") as file:
        digest = hashlib.sha256()
        while block := file.read(READ_BYTES):
            digest.update(block)
        return digest.hexdigest()


def remembered_sha256(path: Place) -> str:
    """Return the SHA-256 of a file, hexadecimal, computed anew only after a file of this machine was written."""
    return _sha256_when(path, path.stat().st_mtime_ns if isinstance(path, Path) else 0)


@cache
def _sha256_when(path: Place, changed_ns: int) -> str:
    return sha256_of(path)


def canonical_json(value: Any) -> str:
    """Return canonical JSON, equal for equal content: sorted keys, no spaces, numpy values as numbers and lists.

    Raises ValueError for NaN and infinity, which JSON cannot hold.
    """
    return json.dumps(plain(value), sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def _flush(path: Path) -> None:
    """Force a file or directory to disk, so that the rename never becomes visible before the content."""
    if ON_WINDOWS and path.is_dir():
        return  # Windows opens no directory
    descriptor = os.open(path, os.O_RDWR if ON_WINDOWS else os.O_RDONLY)  # Windows flushes only what it may write
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
