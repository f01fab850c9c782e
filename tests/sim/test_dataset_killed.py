"""A dataset written by a cluster is the one of a single process, through kills of a worker, scheduler and client."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from sim.dataset_writer import generate
from tests.short import cuts, short

pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
RUNS = int(os.environ.get("MAGBENCH_KILLED_RUNS", "24"))
"""Runs of the dataset; a run takes some 30 ms."""
Process = subprocess.Popen[bytes]


class Parts:
    """The processes of a cluster on this machine."""

    def __init__(self, port: int) -> None:
        self.address, self.port = f"tcp://127.0.0.1:{port}", str(port)
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard")
        self.workers = [self.worker(), self.worker()]

    def worker(self) -> Process:
        """Start a worker of one thread."""
        return self.start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")

    def start(self, part: str, *options: str) -> Process:
        """Start a part by its command."""
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *options]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def restart(self) -> None:
        """Kill the scheduler; start it and its workers anew."""
        for part in (self.scheduler, *self.workers):
            kill(part)
        self.__init__(int(self.port))  # type: ignore[misc]


def kill(part: Process) -> None:
    """Kill a process and wait for its end."""
    part.send_signal(signal.SIGKILL)
    part.wait()


@pytest.fixture
def parts() -> Iterator[Parts]:
    """A scheduler and two workers, each a process."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    made = Parts(port)
    yield made
    for part in (made.scheduler, *made.workers):
        kill(part)


def client(out: Path, address: str) -> Process:
    """Start the command that writes the dataset."""
    options = [text for cut in cuts("tumble") for text in ("--set", cut)]
    command = [sys.executable, "-m", "magbench", "simulate", "tumble", "-o", str(out), "--runs", str(RUNS), *options]
    return subprocess.Popen([*command, "--scheduler", address], stderr=subprocess.DEVNULL)


def wait_for(out: Path, files: int, process: Process) -> int:
    """Wait until a number of files is there or the command has ended; return the number of files."""
    while process.poll() is None and len(list(out.glob("run-*.parquet"))) < files:
        time.sleep(0.02)
    return len(list(out.glob("run-*.parquet")))


@pytest.mark.slow
def test_killed_workers_scheduler_and_client_change_no_byte(parts: Parts, tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "calm", runs=RUNS)
    out = tmp_path / "killed"
    process = client(out, parts.address)
    assert wait_for(out, RUNS // 6, process) < RUNS
    kill(parts.workers[0])
    assert wait_for(out, RUNS // 3, process) < RUNS
    parts.restart()
    assert wait_for(out, RUNS // 2, process) < RUNS
    kill(process)
    second = client(out, parts.address)
    assert second.wait() == 0
    bytes_of = [{path.name: path.read_bytes() for path in place.iterdir()} for place in (tmp_path / "calm", out)]
    assert bytes_of[0] == bytes_of[1]
