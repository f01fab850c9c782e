"""Files that are either whole or not there: written beside, flushed, renamed."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from scenarios.errors import InputError
from scenarios.plain import plain

PART = ".magbench-part"
LOCK_ATTEMPTS = 100
"""How often what is to be locked may vanish under our hands before we call it missing."""


@contextmanager
def beside(path: Path) -> Iterator[Path]:
    """Yields the file to write; when the block ends well it is flushed to disk and renamed to `path`, else removed.

    Raises InputError where the operating system refuses, and where another process writes the same file.
    """
    part = path.with_name(path.name + PART)
    with system_errors_about(path):
        handle = _locked(part, os.O_RDWR | os.O_CREAT, "another magbench is writing this file")
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
        os.close(handle)
    with system_errors_about(path):
        _flush(path.parent)


@contextmanager
def system_errors_about(
    path: Path, do: str = "free some space, or choose a directory that can be written"
) -> Iterator[None]:
    """Turns what the operating system refuses (disk full, no permission, no such file) into an InputError on `path`."""
    try:
        yield
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error).splitlines()[0]
        raise InputError(reason[0].lower() + reason[1:], where=str(path), do=do) from error


@contextmanager
def locked_directory(out: Path) -> Iterator[None]:
    """Makes a directory and keeps other magbench processes out of it; the lock ends with the process, however it ends.

    The lock is on the directory itself, so that it leaves no file behind; a file system that cannot lock a directory
    goes without. A directory that was made and stayed empty is removed again.
    Raises InputError where the directory cannot be made, and where another process holds it.
    """
    made = not out.exists()
    with system_errors_about(out, "choose another output directory"):
        handle = _locked(out, os.O_RDONLY, "another magbench is writing here", partial(_make_directory, out))
    try:
        yield
    finally:
        if made:
            with suppress(OSError):  # not empty
                out.rmdir()
        os.close(handle)


def remove_leftovers(out: Path) -> None:
    """Remove what killed processes left half-written in this directory; InputError where that is refused."""
    for leftover in out.glob(f"*{PART}"):
        with system_errors_about(leftover):
            leftover.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with beside(path) as part, system_errors_about(path):
        part.write_text(text, encoding="utf-8", newline="\n")


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def canonical_json(value: Any) -> str:
    """JSON that is the same text for the same content: sorted keys, no spaces, numpy values as numbers and lists.

    Raises ValueError for NaN and infinity, which JSON cannot hold.
    """
    return json.dumps(plain(value), sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def _flush(path: Path) -> None:
    """Force a file or directory to disk, so that the rename never becomes visible before the content."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _locked(path: Path, flags: int, taken: str, make: Callable[[], object] = lambda: None) -> int:
    """A handle that holds the lock of what stands at `path`; InputError, with what is `taken`, where another has it.

    The one before may remove or rename it as it ends, between our opening it and its lock: then we hold something that
    is no longer there, and begin again.
    """
    for _ in range(LOCK_ATTEMPTS):
        with suppress(FileNotFoundError):
            make()
            handle = os.open(path, flags, 0o666)
            if not _lock(handle):
                os.close(handle)
                do = "wait for it to end, or choose another output"
                raise InputError(taken, where=str(path).removesuffix(PART), do=do)
            if os.path.samestat(os.fstat(handle), os.stat(path)):
                return handle
            os.close(handle)
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))


def _make_directory(out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)


def _lock(handle: int) -> bool:
    """Whether no other process holds the lock; some network file systems have none, and go without."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True
