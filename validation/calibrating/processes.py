"""Processes that others' calibrators run in: their surroundings, their end, and what they said."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType

TIME_LIMIT_S = 60.0
"""How long a fit may take before it counts as failed, unless the user says otherwise."""
LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S = 0.1, 86_400.0
"""What users may say."""
MARK = "MAGBENCH_CHILD"
"""Environment variable by which all that a child started is found again."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Trials share the cores already: threads of a fit would wait for each other, and change its time."""
ROUNDS, ROUND_S = 100, 0.01
"""How often, and how far apart, what a child left is looked for until there is nothing."""
SAID_LINES, SAID_CHARACTERS = 4, 400
"""The end of a program's output that goes into the reason."""
UNPRINTABLE = re.compile(r"[^\x20-\x7e\xa0-\U0010ffff]+")


def surroundings(mark: str, more: Mapping[str, str] = MappingProxyType({})) -> dict[str, str]:
    """The environment of a child: this process's, one thread, and its mark."""
    return {**ONE_THREAD, **os.environ, MARK: mark, **more}


def end_all(leader: int, mark: str) -> None:
    """Kill a child's process group, and what has left the group but not its surroundings; wait until they are gone.

    The latter is found where the system shows processes as files.
    """
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)
    for _ in range(ROUNDS):
        if not _killed(f"{MARK}={mark}".encode()):
            break
        time.sleep(ROUND_S)


def _killed(wanted: bytes) -> int:
    """How many processes with this in their environment were there, and killed."""
    found = 0
    for place in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            if wanted in place.read_bytes().split(b"\0"):
                os.kill(int(place.parent.name), signal.SIGKILL)
                found += 1
    return found


def ending(status: int) -> str:
    """How a process ended, in words; `status` is its exit status, or minus the signal that ended it."""
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):
        return f"ended by {signal.Signals(-status).name}"
    return f"ended by signal {-status}"


def last_lines(output: int, place: Path | None = None) -> str:
    """The end of an open file as one line, the paths under `place` shortened."""
    size = os.fstat(output).st_size
    wanted = 4 * SAID_CHARACTERS  # bytes a character, at most
    text = os.pread(output, wanted, max(0, size - wanted)).decode(errors="replace")
    if place is not None:
        text = text.replace(f"{place}/", "")
    lines = [" ".join(UNPRINTABLE.sub(" ", line).split()) for line in text.splitlines()]
    return " | ".join([line for line in lines if line][-SAID_LINES:])[-SAID_CHARACTERS:]
