"""A calibrator that is a Python object of anybody's, `module:object`."""

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
    """The object that `spec` names (module:object).

    time_limit_s : the time that a fit may take; sha256 : of its module's file, by which a comparison that goes on later
    knows it again.
    It is imported and called in a process of its own, which stays for the next fit: an object that hangs, or ends the
    interpreter, costs that process.
    """

    name: str
    spec: str
    time_limit_s: float
    sha256: str

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """The calibration that the object answers with; a failure of whatever kind is its status."""
        try:
            answer, cpu_s = process_of(self.spec).fit(FitRequest(recording, reference, rng, self.time_limit_s))
        except ProcessLostError as lost:
            return TimedCalibration(failed(self.name, str(lost)), lost.cpu_s)
        found = from_json(json.dumps(answer), where=self.name)
        return TimedCalibration(replace(found, name=self.name), cpu_s)


def default_name(spec: str) -> str:
    """Return the name of `module:object` where the user gives none: the last part of the object's path."""
    return spec.partition(":")[2].rpartition(".")[2]
