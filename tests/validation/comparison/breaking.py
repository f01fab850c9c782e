"""Candidates that do to their worker what calibrators of others do."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib import Reference, Status
from calib.result import Calibration
from recordings import Recording
from validation.calibrating.calibrator_entry import CalibratorEntry, TimedCalibration


@dataclass(frozen=True)
class Killer:
    """Kills its process on every recording whose first sample is the one given; once alone where a file is named."""

    victim_nT: float
    once: str = ""

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        hit = recording.mag_nT[0, 0] == self.victim_nT
        if hit and not (self.once and Path(self.once).exists()):
            if self.once:
                Path(self.once).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return TimedCalibration(
            Calibration(name="killer", status=Status("ok"), offset_nT=recording.mag_nT.mean(axis=0)), 0.0
        )


def killer(victim_nT: float, once: str = "") -> CalibratorEntry:
    """A calibrator whose worker dies in one trial."""
    return CalibratorEntry("killer", Killer(victim_nT, once), attitude_free=True)
