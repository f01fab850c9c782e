"""An external program, run in its own directory with limits on time, files and disk space.

POSIX: a shell sets the limits (`ulimit`) before becoming the program. Windows: the program starts without a shell, and
only the limits watched from here hold.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from validation.calibrating.orphan_guard import guarded
from validation.calibrating.processes import (
    child_environment,
    end_all,
    ending,
    has_ended,
    last_lines,
    locks_limit,
    reap,
    start_options,
)

MAX_FILE_BYTES, MAX_DISK_BYTES, MAX_FILES = 2**26, 2**28, 10_000
"""Limits of a program's output: bytes in a file, bytes in total, files; a calibration takes a few hundred bytes."""
OUTPUT = "output.txt"
PAUSE_S = 0.001, 0.05
"""Shortest and longest time between two checks of a program."""
BLOCK_BYTES = 512
"""The unit of `ulimit -f`."""
LIMITED = (
    "ulimit -c 0; ulimit -f {blocks}; ulimit -t {cpu_s}; "
    "ulimit -w {locks} 2>/dev/null || ulimit -x {locks} 2>/dev/null; "
    'exec "$@"'
)
"""Shell script that sets limits and becomes the program; the processor-time limit ends orphans of this process. The
limit on file locks is the mark, see `processes`: option -w of dash, -x of bash."""


@dataclass(frozen=True)
class ProgramExit:
    """Result of a program: the failure ("" for none), the end of its output, elapsed and processor time in s."""

    failure: str
    output: str
    wall_s: float
    cpu_s: float


def run_program(words: Sequence[str], place: Path, variables: Mapping[str, str], time_limit_s: float) -> ProgramExit:
    """Run a program in the directory `place` until it ends or exceeds a limit, then end all that the program started.

    Standard input is empty; the output goes to a file under the common file limit.
    """
    mark, start_s = uuid.uuid4().hex, time.monotonic()
    with guarded(mark, str(place)), open(place / OUTPUT, "w+b") as output:
        child = subprocess.Popen(
            [*_limits(time_limit_s, mark), *words],
            cwd=place,
            env=child_environment(mark, variables),
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            **start_options(),
        )
        try:
            failure = _watch(child, place, start_s + time_limit_s)
        finally:
            end_all(child.pid, mark)
            cpu_s = reap(child)
        wall_s = time.monotonic() - start_s
        failure = failure or (ending(child.returncode) if child.returncode else "")
        return ProgramExit(failure, last_lines(output.fileno(), place), wall_s, cpu_s)


def _limits(time_limit_s: float, mark: str) -> list[str]:
    """Return the words before a program's own that put it under limits."""
    if sys.platform == "win32":
        return []
    cpu_s = math.ceil(time_limit_s * (os.cpu_count() or 1))
    limits = {"blocks": MAX_FILE_BYTES // BLOCK_BYTES, "cpu_s": cpu_s, "locks": locks_limit(mark)}
    return ["sh", "-c", LIMITED.format(**limits), "sh"]


def _watch(child: subprocess.Popen[bytes], place: Path, deadline_s: float) -> str:
    """Wait for the end of a process and return ""; or return the limit that was exceeded."""
    begun_bytes, pause_s = _used(place)[0], PAUSE_S[0]
    while not has_ended(child):
        if time.monotonic() > deadline_s:
            return "stopped at the time limit"
        used_bytes, files = _used(place)
        if used_bytes - begun_bytes > MAX_DISK_BYTES or files > MAX_FILES:
            return f"stopped: it wrote more than {MAX_DISK_BYTES >> 20} MB, or {MAX_FILES} files"
        time.sleep(pause_s)
        pause_s = min(2 * pause_s, PAUSE_S[1])
    return ""


def _used(place: Path) -> tuple[int, int]:
    """Return bytes and files in a directory; counting stops above MAX_FILES."""
    total_bytes = files = 0
    for folder, _, names in os.walk(place):
        for name in names:
            with suppress(OSError):
                total_bytes += os.lstat(os.path.join(folder, name)).st_size
        files += 1 + len(names)
        if files > MAX_FILES:
            break
    return total_bytes, files
