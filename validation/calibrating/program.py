"""A program run in a directory of its own, with limits on its time and on what it writes."""

from __future__ import annotations

import math
import os
import subprocess
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from validation.calibrating.processes import end_all, ending, last_lines, surroundings

MAX_FILE_BYTES, MAX_DISK_BYTES, MAX_FILES = 2**26, 2**28, 10_000
"""What a program may write: bytes a file, bytes in all, files; a calibration has some hundred bytes."""
OUTPUT = "output.txt"
PAUSE_S = 0.001, 0.05
"""Shortest and longest time between two looks at a program."""
BLOCK_BYTES = 512
"""The unit of `ulimit -f`."""
LIMITED = 'ulimit -c 0; ulimit -f {blocks}; ulimit -t {cpu_s}; exec "$@"'
"""What the shell does before it becomes the program; the limit of processor time ends what outlives this process."""


@dataclass(frozen=True)
class ProgramExit:
    """How a program ended: what went wrong ("" for nothing), the end of its output, the time it took."""

    failure: str
    said: str
    wall_s: float
    cpu_s: float


def run_program(words: Sequence[str], place: Path, variables: Mapping[str, str], time_limit_s: float) -> ProgramExit:
    """Run a program in the directory `place` to its end, or to the limit of time or disk; then all it started ends.

    Its standard input is empty; its output goes to a file that is limited as all files are.
    """
    mark, start_s = uuid.uuid4().hex, time.monotonic()
    with open(place / OUTPUT, "w+b") as output:
        child = subprocess.Popen(
            ["sh", "-c", _limits(time_limit_s), "sh", *words],
            cwd=place,
            env=surroundings(mark, variables),
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            over = _watched(child.pid, place, start_s + time_limit_s)
        finally:
            end_all(child.pid, mark)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        wall_s = time.monotonic() - start_s
        failure = over or (ending(child.returncode) if child.returncode else "")
        return ProgramExit(failure, last_lines(output.fileno(), place), wall_s, usage.ru_utime + usage.ru_stime)


def _limits(time_limit_s: float) -> str:
    cpu_s = math.ceil(time_limit_s * (os.cpu_count() or 1))
    return LIMITED.format(blocks=MAX_FILE_BYTES // BLOCK_BYTES, cpu_s=cpu_s)


def _watched(child: int, place: Path, deadline_s: float) -> str:
    """Wait for the end of a process, which stays to be waited for; what it has too much of, or ""."""
    begun_bytes, pause_s = _used(place)[0], PAUSE_S[0]
    while os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > deadline_s:
            return "stopped at the time limit"
        used_bytes, files = _used(place)
        if used_bytes - begun_bytes > MAX_DISK_BYTES or files > MAX_FILES:
            return f"stopped: it wrote more than {MAX_DISK_BYTES >> 20} MB, or {MAX_FILES:,} files"
        time.sleep(pause_s)
        pause_s = min(2 * pause_s, PAUSE_S[1])
    return ""


def _used(place: Path) -> tuple[int, int]:
    """Bytes and files in a directory, counted until there are too many."""
    total_bytes = files = 0
    for folder, _, names in os.walk(place):
        for name in names:
            with suppress(OSError):
                total_bytes += os.lstat(os.path.join(folder, name)).st_size
        files += 1 + len(names)
        if files > MAX_FILES:
            break
    return total_bytes, files
