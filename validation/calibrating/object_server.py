"""Program of an object's process: import one Python object and serve fit requests.

POSIX: the system limits the size of written files (`setrlimit`) and the time of a fit (interval timer). On Windows only
the parent process ends a fit at the time limit.
"""

from __future__ import annotations

import importlib
import json
import os
import pickle
import signal
import sys
import time
import traceback
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing import connection as connections
from pathlib import Path

import numpy as np

from calib import Calibration, to_dict
from calib.external import ExternalMethod, external_method, fit_external, needs_of
from calib.reference import Reference
from recordings import Recording
from recordings.files import sha256_of
from scenarios.errors import InputError
from validation.calibrating.calibrator_entry import failed, time_fit
from validation.calibrating.processes import MARK, carry_mark
from validation.calibrating.program import MAX_FILE_BYTES

ALARM_S = 5.0
"""Time after the limit at which the process ends itself, in case the parent process is gone."""


@dataclass(frozen=True)
class FitRequest:
    """One fit: recording, reference, random generator and time limit."""

    recording: Recording
    reference: Reference
    rng: np.random.Generator
    time_limit_s: float


@dataclass(frozen=True)
class ObjectFacts:
    """What an object declares, the file of its module, and the SHA-256 of the file as loaded."""

    needs: tuple[str, ...]
    whole_array: bool
    eddy: bool
    file: str
    sha256: str


def serve(handle: int, spec: str) -> None:
    """Import `module:object` and answer requests on an open connection until the connection is closed."""
    connection = _opened(handle)
    carry_mark(os.environ[MARK])
    _limit_files()
    sys.path.insert(0, os.getcwd())  # only now: magbench is imported, whatever names the directory holds
    try:
        method = load_object(spec)
        file = sys.modules[spec.partition(":")[0]].__file__ or ""
        whole_array, eddy = (bool(getattr(method, fact, False)) for fact in ("whole_array", "eddy"))
        facts = ObjectFacts(needs_of(method, spec), whole_array, eddy, file, content_of(file))
    except InputError as error:
        _send(connection, refused={"what": error.what, "do": error.do})
        return
    _send(connection, facts=asdict(facts))
    while True:
        try:
            request = connection.recv_bytes()
        except EOFError:
            return
        answer = time_fit(partial(_answer, method, pickle.loads(request), spec))
        _send(connection, calibration=to_dict(answer.calibration), fit_cpu_s=answer.cpu_s)


def load_object(spec: str) -> ExternalMethod:
    """Import the calibrator or function `module:object`; InputError names what is missing."""
    module, _, path = spec.partition(":")
    try:
        found: object = importlib.import_module(module)
    except Exception as error:
        raise InputError(f"{type(error).__name__}: {error}", where=spec, do=f"check module {module}") from None
    for name in path.split("."):
        if not hasattr(found, name):
            raise InputError(f"has no {path}", where=module, do="give module:object")
        found = getattr(found, name)
    return external_method(found, spec)


def content_of(file: str) -> str:
    """Return the SHA-256 of a file, hexadecimal; "" without a file, as for a built-in module."""
    return sha256_of(Path(file)) if os.path.isfile(file) else ""


def _answer(method: ExternalMethod, request: FitRequest, spec: str) -> Calibration:
    _set_alarm(request.time_limit_s + ALARM_S)
    try:
        return fit_external(method, request.recording, request.reference, request.rng, spec)
    except InputError as error:
        return failed(spec, str(error))
    except Exception as error:
        return failed(spec, f"{type(error).__name__}: {error}{_place(error, spec)}")
    finally:
        _set_alarm(0.0)


def _opened(handle: int) -> connections.Connection:
    if sys.platform == "win32":
        return connections.PipeConnection(handle)
    return connections.Connection(handle)


def _limit_files() -> None:
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_FILE_BYTES, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


def _set_alarm(after_s: float) -> None:
    """End the process after a time; 0: never."""
    if sys.platform != "win32":
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, after_s)


def _place(error: Exception, spec: str) -> str:
    """Return the file and line of an error in the object's own module, in brackets; "" where none is known."""
    module = sys.modules[spec.partition(":")[0]].__file__
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == module]
    return f" ({os.path.basename(frames[-1].filename)}:{frames[-1].lineno})" if frames else ""


def _send(connection: connections.Connection, **answer: object) -> None:
    """Send an answer and the processor time of the process so far."""
    connection.send_bytes(json.dumps(answer | {"process_cpu_s": time.process_time()}).encode())
