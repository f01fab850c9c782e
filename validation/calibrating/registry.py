"""Registered calibrators: Python objects in memory, given a name by a notebook or a test."""

from __future__ import annotations

import pickle
import re
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from calib import CALIBRATORS, Reference
from calib.base import Calibrator
from calib.external import ExternalMethod, external_method, fit_external
from recordings import Recording
from scenarios.errors import InputError
from validation.calibrating.calibrator_entry import TimedCalibration, time_fit

NAME = re.compile(r"[A-Za-z][\w.-]*")
REGISTERED: dict[str, ExternalMethod] = {}


@dataclass(frozen=True)
class RegisteredObject:
    """A registered object, called in the process that fits; pickled by reference to module and name."""

    name: str
    method: ExternalMethod

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """Fit a recording in the calling process; exceptions of the object propagate."""
        return time_fit(lambda: fit_external(self.method, recording, reference, rng, self.name))

    def __reduce__(self) -> tuple[type[RegisteredObject], tuple[str, ExternalMethod]]:
        """Pickle by reference; InputError for an object that other processes cannot import."""
        if not _importable(self.method):
            raise InputError(
                "is registered in this process, and other processes cannot import it",
                where=self.name,
                do="put it into a module and name it module:object, or use one job",
            )
        return RegisteredObject, (self.name, self.method)


def register(found: object, name: str | None = None) -> None:
    """Register a Calibrator (class or instance), or a function accepted by `calib.external`, under a name.

    name : by default the object's own; an earlier registration of equal name is replaced. Raises InputError for any
    other object, and for the name of a built-in calibrator.
    """
    called = name or getattr(found, "name", None) or getattr(found, "__name__", None)
    if not isinstance(called, str) or not NAME.fullmatch(called):
        raise InputError(f"{called!r} is no name of a calibrator", where="register", do='give one: name="mine"')
    if called in CALIBRATORS:
        do = 'choose another: name="mine"'
        raise InputError(f"{called!r} is one of magbench's own calibrators", where="register", do=do)
    REGISTERED[called] = external_method(found, called)


def _importable(method: ExternalMethod) -> bool:
    """Return whether a new process can import the object."""
    home = type(method) if isinstance(method, Calibrator) else method
    module = getattr(home, "__module__", None) or type(method).__module__
    try:
        return module != "__main__" and find_spec(module) is not None and bool(pickle.dumps(method))
    except Exception:
        return False
