"""Programs of a process that is killed with SIGKILL end with it, and their directories go."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

PARENT = """
import sys
from pathlib import Path
from validation.calibrating.program import run_program
run_program(["sh", "-c", sys.argv[2]], Path(sys.argv[1]), {}, 60.0)
"""
IGNORING = "trap '' TERM INT HUP; echo $$ > ../pid; while :; do sleep 0.1; done"
EMPTY = "env -i /usr/bin/setsid /bin/sh -c 'echo $$ > ../pid; exec sleep 60' & sleep 60"
LEAVING = "setsid sh -c 'echo $$ > ../pid; sleep 60' & sleep 60"


def _soon(true: object, within_s: float = 20.0) -> bool:
    until_s = time.monotonic() + within_s
    while time.monotonic() < until_s:
        if true():  # type: ignore[operator]
            return True
        time.sleep(0.02)
    return False


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="marked processes are found in /proc")
@pytest.mark.parametrize("program", [IGNORING, LEAVING, EMPTY], ids=["ignores signals", "leaves", "leaves unmarked"])
def test_a_program_ends_with_a_killed_process_and_its_directory_goes(tmp_path: Path, program: str) -> None:
    place, told = tmp_path / "magbench-fit", tmp_path / "pid"
    place.mkdir()
    parent = subprocess.Popen([sys.executable, "-c", PARENT, str(place), program])
    assert _soon(lambda: told.exists() and told.read_text().strip())
    pid = int(told.read_text())
    assert _runs(pid)
    os.kill(parent.pid, signal.SIGKILL)
    parent.wait()
    assert _soon(lambda: not _runs(pid))
    assert _soon(lambda: not place.exists())
