"""A calibrator under test: name, facts, and fit method."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

import calib
from calib import Calibration, Reference, Status
from recordings import Recording
from scenarios.errors import InputError


@dataclass(frozen=True)
class TimedCalibration:
    """A calibration and the processor time of the fit, s, summed over all processes that took part."""

    calibration: Calibration
    cpu_s: float


class FitMethod(Protocol):
    """How a calibrator is run: in the calling process, in the process of a Python object, or as an external program.

    Instances hold names and settings only, can be pickled, and load code when called.
    """

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """Return the calibration of a recording."""


@dataclass(frozen=True)
class CalibratorEntry:
    """A calibrator that takes part in a run, comparison or gate; small, frozen, and equal in every process.

    attitude_free : no attitude is used; scores leave out the rotation not determined by the field strength.
    whole_array : all sensors of an array are fitted at once. eddy : eddy currents are estimated too.
    needs : what the recording must hold, keys of `calib.base.NEEDS`.
    """

    name: str
    method: FitMethod
    attitude_free: bool
    whole_array: bool = False
    eddy: bool = False
    needs: tuple[str, ...] = ()

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Calibration:
        """Return the calibration of a recording; see `fit_timed`."""
        return self.fit_timed(recording, reference, rng).calibration

    def fit_timed(
        self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None
    ) -> TimedCalibration:
        """Return calibration and processor time; rng (default: seed 0) matters to stochastic methods only.

        Any exception of the calibrator becomes the status `not_converged`, with the message as reason.
        """
        start_s = time.process_time()
        try:
            return self.method.fit(recording, reference, rng or np.random.default_rng(0))
        except InputError as error:
            reason = str(error)
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
        return TimedCalibration(failed(self.name, reason), time.process_time() - start_s)


@dataclass(frozen=True)
class BuiltIn:
    """A calibrator of `calib.CALIBRATORS`, with options in the name: `NAME:OPTION=VALUE`."""

    name: str

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """Fit a recording in the calling process."""
        return time_fit(lambda: replace(calib.get(self.name).fit(recording, reference, rng), name=self.name))


def time_fit(fit: Callable[[], Calibration]) -> TimedCalibration:
    """Run a fit in the calling process and measure the processor time."""
    start_s = time.process_time()
    calibration = fit()
    return TimedCalibration(calibration, time.process_time() - start_s)


def failed(name: str, reason: str) -> Calibration:
    """Return the calibration of a method that gave no answer: status `not_converged`, offset 0, matrix I."""
    return Calibration(name=name, status=Status("not_converged", reason))
