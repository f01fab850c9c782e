"""A guard process that ends calibrators' child processes and removes their directories when magbench is killed.

The guard reads a pipe whose other end this process alone holds: the end of the file tells of the end of this process,
by whatever signal. One guard serves all children of a process. Windows: no guard.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache

from validation.calibrating.processes import LOCKS_DIGITS, MARK

GUARD = """
import os, re, shutil, signal, sys, time
from pathlib import Path
held = {}
for line in sys.stdin.buffer:
    mark, _, place = line.rstrip(b"\\n").partition(b" ")
    if mark in held:
        del held[mark]
    else:
        held[mark] = place
def carries(process):
    limit = re.search(rb"Max file locks +(\\d+)", (process / "limits").read_bytes())
    if limit and int(limit[1]) in limits:
        return (process / "stat").read_bytes().rpartition(b")")[2].split()[0] != b"Z"
    return bool(wanted.intersection((process / "environ").read_bytes().split(b"\\0")))
def killed():
    count = 0
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if carries(process):
                os.kill(int(process.name), signal.SIGKILL)
                count += 1
        except OSError:
            pass
    return count
wanted = {b"MAGBENCH_CHILD=" + mark for mark in held}
limits = {int(mark[:DIGITS], 16) for mark in held}
for _ in range(200 if held else 0):
    if not killed():
        break
    time.sleep(0.01)
for place in filter(None, held.values()):
    shutil.rmtree(place, ignore_errors=True)
"""
GUARD = GUARD.replace("DIGITS", str(LOCKS_DIGITS)).replace("MAGBENCH_CHILD", MARK)
"""Program of the guard. Each line names a child's mark and directory; a mark's second line says that it has ended."""
_LOCK = threading.Lock()


def guard(mark: str, place: str = "") -> None:
    """Have the processes with a mark ended, and the directory removed, at the end of this process."""
    if sys.platform != "win32":
        _tell(f"{mark} {place}\n")


def release(mark: str) -> None:
    """Tell that the processes with a mark have ended."""
    if sys.platform != "win32":
        _tell(f"{mark}\n")


@contextmanager
def guarded(mark: str, place: str) -> Iterator[None]:
    """Guard a child and its directory for the time of a block."""
    guard(mark, place)
    try:
        yield
    finally:
        release(mark)


def _tell(line: str) -> None:
    with _LOCK, suppress(BrokenPipeError):
        os.write(_pipe_of(os.getpid()), os.fsencode(line))


@lru_cache(maxsize=1)
def _pipe_of(process: int) -> int:
    """Start the guard of a process, and return the writing end of the pipe; a forked process gets its own guard."""
    theirs, ours = os.pipe()
    words, quiet = [sys.executable, "-I", "-S", "-c", GUARD], subprocess.DEVNULL
    _STARTED.append(subprocess.Popen(words, stdin=theirs, stdout=quiet, stderr=quiet, start_new_session=True))
    os.close(theirs)
    return ours


_STARTED: list[subprocess.Popen[bytes]] = []
"""Guards that were started, kept so that none is reported as left running."""
