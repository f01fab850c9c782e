"""Opens the rerun viewer on a recording, served to this machine alone."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from magbench.console import say
from magbench.recording_server import HOST, RecordingServer
from reports.viewer import viewer_program
from scenarios.errors import InputError

MOST_WAIT_S = 20.0
"""Time in which the viewer's page must be there."""


def view(file: Path, *, web: bool = False) -> None:
    """Show a recording in a window, or with `web` in a browser on this machine, until the user ends it.

    Raises InputError where there is no screen for a window, and where the viewer does not start.
    """
    if web:
        _serve(file)
    elif not _has_screen():
        raise InputError("there is no screen for the viewer's window", where=str(file), do="add --web to use a browser")
    else:
        subprocess.run([viewer_program(), str(file), "--bind", HOST], check=True)


def _has_screen() -> bool:
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _serve(file: Path) -> None:
    """Serve viewer and recording until Ctrl-C; the page of the bare address goes to the recording with its layout.

    The viewer reads the file itself, by HTTP: what rerun passes on as a stream of messages loses the layout.
    """
    with _web_viewer() as viewer, RecordingServer(file, viewer) as server, _ended_by_the_user() as ended:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        say(f"open {server.address} ; Ctrl-C ends")
        if _has_screen():
            webbrowser.open(server.address)
        ended.wait()
        server.shutdown()


@contextmanager
def _ended_by_the_user() -> Iterator[threading.Event]:
    """Yield an event that Ctrl-C sets: here the usual end and no interruption."""
    ended = threading.Event()
    before = signal.signal(signal.SIGINT, lambda number, frame: ended.set())
    try:
        yield ended
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _web_viewer() -> Iterator[str]:
    """Run rerun's web viewer, without a recording and without its log; yields its address."""
    with socket.create_server((HOST, 0)) as free:
        port = free.getsockname()[1]
    places = ["--bind", HOST, "--web-viewer-port", str(port), "--port", "auto"]
    command = [str(viewer_program()), "--serve-web", *places]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        _wait_for(port, process)
        yield f"http://{HOST}:{port}"
    finally:
        process.kill()  # it holds nothing, and takes seconds to end by itself
        process.wait()


def _wait_for(port: int, process: subprocess.Popen[bytes]) -> None:
    """Wait until the viewer answers; InputError where it ends or stays silent."""
    until_s = time.monotonic() + MOST_WAIT_S
    while process.poll() is None and time.monotonic() < until_s:
        try:
            socket.create_connection((HOST, port), timeout=1.0).close()
            return
        except OSError:
            time.sleep(0.1)
    raise InputError("the viewer does not start", where="rerun", do="try `rerun --serve-web`, which tells why")
