"""What runs in the process of an outside object: it loads the object, and fits as often as it is asked."""

from __future__ import annotations

import importlib
import json
import os
import pickle
import resource
import signal
import sys
import time
import traceback
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from calib import Calibration, to_dict
from calib.outside import Outside, fitted, needs_of, outside
from calib.reference import Reference
from recordings import Recording
from recordings.files import sha256_of
from scenarios.errors import InputError
from validation.calibrating.calibrator_entry import failed, time_fit
from validation.calibrating.program import MAX_FILE_BYTES

ALARM_S = 5.0
"""How long after the limit of time the process ends by itself, where the one that should end it is gone."""


@dataclass(frozen=True)
class FitRequest:
    """One fit: what is fitted, and how long it may take."""

    recording: Recording
    reference: Reference
    rng: np.random.Generator
    time_limit_s: float


@dataclass(frozen=True)
class ObjectFacts:
    """What an object says of itself, the file of its module, and which content of it was loaded."""

    needs: tuple[str, ...]
    whole_array: bool
    eddy: bool
    file: str
    sha256: str


def serve(handle: int, spec: str) -> None:
    """Load `module:object` and answer requests on an open connection until it is closed."""
    connection = Connection(handle)
    resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_FILE_BYTES, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    sys.path.insert(0, os.getcwd())  # after our own packages are imported, which those here may share names with
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


def load_object(spec: str) -> Outside:
    """The calibrator or function that `module:object` names; InputError says why it cannot be had."""
    module, _, path = spec.partition(":")
    try:
        found: object = importlib.import_module(module)
    except Exception as error:
        raise InputError(f"{type(error).__name__}: {error}", where=spec, do=f"check module {module}") from None
    for name in path.split("."):
        if not hasattr(found, name):
            raise InputError(f"has no {path}", where=module, do="give module:object")
        found = getattr(found, name)
    return outside(found, spec)


def content_of(file: str) -> str:
    """SHA-256 of a file, hexadecimal; of what is no file, as a module that is built in, nothing."""
    return sha256_of(Path(file)) if os.path.isfile(file) else ""


def _answer(method: Outside, request: FitRequest, spec: str) -> Calibration:
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, request.time_limit_s + ALARM_S)
    try:
        return fitted(method, request.recording, request.reference, request.rng, spec)
    except InputError as error:
        return failed(spec, str(error))
    except Exception as error:
        return failed(spec, f"{type(error).__name__}: {error}{_place(error, spec)}")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _place(error: Exception, spec: str) -> str:
    """Where in the object's own module an error arose."""
    module = sys.modules[spec.partition(":")[0]].__file__
    frames = [one for one in traceback.extract_tb(error.__traceback__) if one.filename == module]
    return f" ({os.path.basename(frames[-1].filename)}:{frames[-1].lineno})" if frames else ""


def _send(connection: Connection, **answer: object) -> None:
    """Send an answer, and the processor time that this process has taken until now."""
    connection.send_bytes(json.dumps(answer | {"process_cpu_s": time.process_time()}).encode())
