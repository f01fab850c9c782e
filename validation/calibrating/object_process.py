"""The process that an outside object lives in: kept over many fits, made anew when it was lost."""

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
from validation.calibrating.processes import end_all, ending, last_lines, surroundings

START_LIMIT_S = 120.0
"""How long an object's module may take to be imported."""
ENDING_S = 2.0
"""How long a process that hangs up may take to end by itself, so that it is told how it ended."""
MAX_ANSWER_BYTES = 2**24


class ProcessLostError(Exception):
    """The object's process ended, or had to be ended; `cpu_s` is its processor time since its last answer."""

    def __init__(self, reason: str, cpu_s: float) -> None:
        super().__init__(reason)
        self.cpu_s = cpu_s


class ObjectProcess:
    """The process of one object, which does one thing at a time; it is made when needed, and anew after it was lost."""

    def __init__(self, spec: str) -> None:
        self._spec, self._lock = spec, threading.Lock()
        self._child: _Child | None = None

    def facts(self) -> ObjectFacts:
        """What the object says of itself; InputError where it cannot be loaded."""
        with self._lock:
            try:
                self._end_what_is_old()
                return self._running().facts
            except ProcessLostError as lost:
                raise InputError(f"cannot be loaded: {lost}", where=self._spec) from None

    def fit(self, request: FitRequest) -> tuple[dict[str, Any], float]:
        """The calibration as plain values, and the processor time that it took; raises Lost."""
        with self._lock:
            return self._running().fit(request)

    def _end_what_is_old(self) -> None:
        """Where the module's file has changed since, the next process loads it anew."""
        if self._child is not None and content_of(self._child.facts.file) != self._child.facts.sha256:
            self._child.end()
            self._child = None

    def _running(self) -> _Child:
        if self._child is None or self._child.process.poll() is not None:
            self._child = _Child(self._spec)
        return self._child


class _Child:
    """One life of the process."""

    def __init__(self, spec: str) -> None:
        self.mark, self.cpu_s = uuid.uuid4().hex, 0.0
        self.output = tempfile.TemporaryFile()  # noqa: SIM115
        self.connection, theirs = Pipe()
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-c", _program(theirs.fileno(), spec)],
                env=surroundings(self.mark),
                stdin=subprocess.DEVNULL,
                stdout=self.output,
                stderr=subprocess.STDOUT,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,
            )
        begun = self._received(START_LIMIT_S)
        if "refused" in begun:
            raise InputError(begun["refused"]["what"], where=spec, do=begun["refused"]["do"])
        self.facts = ObjectFacts(**begun["facts"] | {"needs": tuple(begun["facts"]["needs"])})

    def fit(self, request: FitRequest) -> tuple[dict[str, Any], float]:
        """As Host's."""
        os.ftruncate(self.output.fileno(), 0)
        answer = self._received(request.time_limit_s, pickle.dumps(request, pickle.HIGHEST_PROTOCOL))
        return answer["calibration"], answer["fit_cpu_s"]

    def _received(self, limit_s: float, request: bytes = b"") -> dict[str, Any]:
        """The next message, after a request or at the start; raises Lost."""
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
            self._let_end()
            raise self._lost() from None
        except BaseException:
            self._lost()
            raise

    def _let_end(self) -> None:
        deadline_s = time.monotonic() + ENDING_S
        flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
        while os.waitid(os.P_PID, self.process.pid, flags) is None and time.monotonic() < deadline_s:
            time.sleep(0.01)

    def _lost(self, why: str = "") -> ProcessLostError:
        """End the process; how it ended is the reason, unless `why` is."""
        cpu_s, said = self.end()
        reason = why or f"the interpreter ended: {ending(self.process.returncode)}"
        return ProcessLostError(f"{reason}; it said: {said}" if said else reason, cpu_s - self.cpu_s)

    def end(self) -> tuple[float, str]:
        """End the process and all that it started; its processor time, and the end of what it said."""
        end_all(self.process.pid, self.mark)
        _, status, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = os.waitstatus_to_exitcode(status)
        said = last_lines(self.output.fileno())
        self.connection.close()
        self.output.close()
        return usage.ru_utime + usage.ru_stime, said


def _program(handle: int, spec: str) -> str:
    """What the process runs; it imports what this one can, and our packages before anything of the user's."""
    path = [place for place in sys.path if place]
    return f"import sys; sys.path[:] = {path!r}; from {serve.__module__} import serve; serve({handle}, {spec!r})"


_HOSTS: dict[tuple[str, str], ObjectProcess] = {}


def process_of(spec: str) -> ObjectProcess:
    """This process's host of an object; the same name may be another object in another directory."""
    return _HOSTS.setdefault((spec, os.getcwd()), ObjectProcess(spec))
