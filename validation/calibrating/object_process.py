"""The child process of a Python object: kept over many fits, and restarted after a loss."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from multiprocessing import Pipe
from typing import Any

from scenarios.errors import InputError
from validation.calibrating.object_server import FitRequest, ObjectFacts, content_of, serve
from validation.calibrating.orphan_guard import guard, release
from validation.calibrating.processes import (
    child_environment,
    end_all,
    ending,
    has_ended,
    last_lines,
    reap,
    start_options,
)

START_LIMIT_S = 120.0
"""Time limit of importing an object's module."""
ENDING_S = 2.0
"""Time in which a process that closed the connection may end by itself, so that its exit status is known."""
MAX_ANSWER_BYTES = 2**24


class ProcessLostError(Exception):
    """The object's process ended, or had to be ended; cpu_s : processor time since the last answer."""

    def __init__(self, reason: str, cpu_s: float) -> None:
        super().__init__(reason)
        self.cpu_s = cpu_s


class ObjectProcess:
    """The process of one object; requests are served one at a time, and the process starts at the first request."""

    def __init__(self, spec: str) -> None:
        self._spec, self._lock = spec, threading.Lock()
        self._child: _Child | None = None

    def facts(self) -> ObjectFacts:
        """Return what the object declares; a changed module is loaded again. InputError where loading fails."""
        with self._lock:
            if self._child is not None and content_of(self._child.facts.file) != self._child.facts.sha256:
                self._child.end()
                self._child = None
            try:
                return self._running().facts
            except ProcessLostError as lost:
                raise InputError(f"cannot be loaded: {lost}", where=self._spec) from None

    def fit(self, request: FitRequest) -> tuple[dict[str, Any], float]:
        """Return the calibration as plain values and the fit's processor time; raises ProcessLostError."""
        with self._lock:
            return self._running().fit(request)

    def _running(self) -> _Child:
        if self._child is None or self._child.process.poll() is not None:
            self._child = _Child(self._spec)
        return self._child


class _Child:
    """One run of the process, from import to end."""

    def __init__(self, spec: str) -> None:
        self.mark, self.cpu_s = uuid.uuid4().hex, 0.0
        guard(self.mark)
        self.output = tempfile.TemporaryFile()  # noqa: SIM115
        self.connection, theirs = Pipe()
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-c", _program(theirs.fileno(), spec)],
                env=child_environment(self.mark),
                stdin=subprocess.DEVNULL,
                stdout=self.output,
                stderr=subprocess.STDOUT,
                **start_options(theirs.fileno()),
            )
        begun = self._received(START_LIMIT_S)
        if "refused" in begun:
            raise InputError(begun["refused"]["what"], where=spec, do=begun["refused"]["do"])
        self.facts = ObjectFacts(**begun["facts"] | {"needs": tuple(begun["facts"]["needs"])})

    def fit(self, request: FitRequest) -> tuple[dict[str, Any], float]:
        """See `ObjectProcess.fit`."""
        os.ftruncate(self.output.fileno(), 0)
        answer = self._received(request.time_limit_s, pickle.dumps(request, pickle.HIGHEST_PROTOCOL))
        return answer["calibration"], answer["fit_cpu_s"]

    def _received(self, limit_s: float, request: bytes = b"") -> dict[str, Any]:
        """Send a request, if any, and return the next message; raises ProcessLostError."""
        try:
            if request:
                self.connection.send_bytes(request)
            if not self.connection.poll(limit_s):
                raise TimeoutError
            message: dict[str, Any] = json.loads(self.connection.recv_bytes(MAX_ANSWER_BYTES))
            self.cpu_s = message["process_cpu_s"]
            return message
        except TimeoutError:
            raise self._lost("stopped at the time limit") from None
        except (OSError, EOFError, ValueError):
            self._await_end()
            raise self._lost() from None
        except BaseException:
            self._lost()
            raise

    def _await_end(self) -> None:
        deadline_s = time.monotonic() + ENDING_S
        while not has_ended(self.process) and time.monotonic() < deadline_s:
            time.sleep(0.01)

    def _lost(self, why: str = "") -> ProcessLostError:
        """End the process and return the error; the reason is `why`, else the exit status."""
        cpu_s, output = self.end()
        reason = why or f"the interpreter ended: {ending(self.process.returncode)}"
        return ProcessLostError(f"{reason}; it said: {output}" if output else reason, cpu_s - self.cpu_s)

    def end(self) -> tuple[float, str]:
        """End the process and all descendants; return the processor time and the end of the output."""
        end_all(self.process.pid, self.mark)
        release(self.mark)
        cpu_s = reap(self.process)
        output = last_lines(self.output.fileno())
        self.connection.close()
        self.output.close()
        return cpu_s, output


def _program(handle: int, spec: str) -> str:
    """Return the child's Python program: the search path of this process, and magbench imported before user code."""
    path = [place for place in sys.path if place]
    return f"import sys; sys.path[:] = {path!r}; from {serve.__module__} import serve; serve({handle}, {spec!r})"


_PROCESSES: dict[tuple[str, str], ObjectProcess] = {}
"""By module:object and working directory, since a name may mean a different object in a different directory."""


def process_of(spec: str) -> ObjectProcess:
    """Return the process of an object `module:object`, seen from the working directory."""
    return _PROCESSES.setdefault((spec, os.getcwd()), ObjectProcess(spec))
