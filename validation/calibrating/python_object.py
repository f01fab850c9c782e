"""A calibrator that is a Python object given as `module:object`."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np

from calib import Reference, from_json
from recordings import Recording
from validation.calibrating.calibrator_entry import TimedCalibration, failed
from validation.calibrating.object_process import ProcessLostError, process_of
from validation.calibrating.object_server import FitRequest


@dataclass(frozen=True)
class ImportedObject:
    """The object `spec` (module:object), imported and called in a child process that is kept between fits.

    time_limit_s : time limit of one fit. sha256 : digest of the module's file, so that a resumed comparison notices a
    changed module. An object that hangs or ends the interpreter costs the child process alone.
    """

    name: str
    spec: str
    time_limit_s: float
    sha256: str

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """Fit one recording in the object's process; every failure becomes the status."""
        try:
            answer, cpu_s = process_of(self.spec).fit(FitRequest(recording, reference, rng, self.time_limit_s))
        except ProcessLostError as lost:
            return TimedCalibration(failed(self.name, str(lost)), lost.cpu_s)
        found = from_json(json.dumps(answer), where=self.name)
        return TimedCalibration(replace(found, name=self.name), cpu_s)


def default_name(spec: str) -> str:
    """Return the name of `module:object` where the user gives none: the last part of the object's path."""
    return spec.partition(":")[2].rpartition(".")[2]
