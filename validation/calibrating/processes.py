"""Child processes of external calibrators: environment, start, end, processor time and last output.

POSIX: a child leads a new process group; `os.killpg` kills the group, `os.wait4` gives the processor time.
Linux: everything that a child starts carries the child's mark, as an environment variable and as a resource limit: a
descendant with an empty environment and a session of its own is found by the limit.
Windows: a child starts a new process group; `taskkill /T` ends the tree, and no processor time is reported.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any

TIME_LIMIT_S = 60.0
"""Default time limit of a fit; a longer fit counts as failed."""
LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S = 0.1, 86_400.0
"""Range of time limits that users may set."""
MARK = "MAGBENCH_CHILD"
"""Environment variable that marks every process started by a child."""
LOCKS_LIMIT, LOCKS_DIGITS = 10, 14
"""Number of Linux's limit on file locks, which the kernel has not enforced since 2003, and the digits of a mark in its
value. A limit is inherited, and without privileges no process can raise the limit again."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Trials already share the cores: threads within a fit would wait for each other and change the measured time."""
ROUNDS, ROUND_S = 100, 0.01
"""Number and interval of searches for marked processes that survive the kill."""
OUTPUT_LINES, OUTPUT_CHARACTERS = 4, 400
"""Length of the program output quoted in a failure's reason."""
UNPRINTABLE = re.compile(r"[^\x20-\x7e\xa0-\U0010ffff]+")


def child_environment(mark: str, more: Mapping[str, str] = MappingProxyType({})) -> dict[str, str]:
    """Return the environment of a child: the environment of this process, single-threaded BLAS, and the mark."""
    return {**ONE_THREAD, **os.environ, MARK: mark, **more}


def start_options(handle: int | None = None) -> dict[str, Any]:
    """Return the `subprocess.Popen` options of a child in a new process group that inherits one open handle."""
    if sys.platform == "win32":
        options: dict[str, Any] = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        if handle is not None:
            os.set_handle_inheritable(handle, True)
            options["startupinfo"] = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
        return options
    return {"start_new_session": True, "pass_fds": () if handle is None else (handle,)}


def has_ended(child: subprocess.Popen[bytes]) -> bool:
    """Return whether a child has ended; on POSIX the child stays a zombie, so `reap` can read its processor time."""
    if sys.platform == "win32":
        return child.poll() is not None
    return os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def reap(child: subprocess.Popen[bytes]) -> float:
    """Wait for a child, set its return code, and return its processor time, s (0 on Windows)."""
    if sys.platform == "win32":
        child.wait()
        return 0.0
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime


def end_all(leader: int, mark: str) -> None:
    """Kill a child's process group and every process that carries the mark; return when all are gone.

    A process that left the group is found by the mark in /proc, where /proc exists; elsewhere such a process lives on.
    """
    if sys.platform == "win32":
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(leader)], capture_output=True, check=False)
        return
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)
    for _ in range(ROUNDS):
        marked = [process for process in Path("/proc").glob("[0-9]*") if _carries(process, mark)]
        if not marked:
            break
        for process in marked:
            with suppress(OSError):
                os.kill(int(process.name), signal.SIGKILL)
        time.sleep(ROUND_S)


def locks_limit(mark: str) -> int:
    """Return the limit on file locks that stands for a mark of hexadecimal digits."""
    return int(mark[:LOCKS_DIGITS], 16)


def carry_mark(mark: str) -> None:
    """Put the mark of a child on this process and all that it starts (Linux)."""
    if sys.platform == "linux":
        import resource

        resource.setrlimit(LOCKS_LIMIT, (locks_limit(mark), locks_limit(mark)))


def _carries(process: Path, mark: str) -> bool:
    """Return whether a process of /proc carries a mark; a process that has ended, a zombie too, does not."""
    with suppress(OSError):
        limits = re.search(rb"^Max file locks +(\d+)", (process / "limits").read_bytes(), re.MULTILINE)
        if limits is not None and int(limits[1]) == locks_limit(mark):
            return (process / "stat").read_bytes().rpartition(b")")[2].split()[0] != b"Z"
        return f"{MARK}={mark}".encode() in (process / "environ").read_bytes().split(b"\0")
    return False


def ending(status: int) -> str:
    """Describe the end of a process; status : exit status, or minus the number of the signal."""
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):
        return f"ended by {signal.Signals(-status).name}"
    return f"ended by signal {-status}"


def last_lines(output: int, place: Path | None = None) -> str:
    """Return the last lines of an open file, joined by bars; the path `place` is removed. The writer has ended."""
    wanted = 4 * OUTPUT_CHARACTERS  # at most four bytes a character
    os.lseek(output, max(0, os.fstat(output).st_size - wanted), os.SEEK_SET)
    text = os.read(output, wanted).decode(errors="replace")
    if place is not None:
        text = text.replace(f"{place}{os.sep}", "")
    lines = [" ".join(UNPRINTABLE.sub(" ", line).split()) for line in text.splitlines()]
    return " | ".join([line for line in lines if line][-OUTPUT_LINES:])[-OUTPUT_CHARACTERS:]
