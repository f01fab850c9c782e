"""What every way of calibrating gives back."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from calib import Calibration, Reference, Status
from recordings import Recording


@dataclass(frozen=True)
class Fitted:
    """A calibration, and the processor time that it took in whatever processes, s."""

    calibration: Calibration
    cpu_s: float


class FitMethod(Protocol):
    """How a candidate fits; it holds names and settings alone, and loads what it needs when it is called."""

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Fitted:
        """The calibration of one recording."""


def timed(fit: Callable[[], Calibration]) -> Fitted:
    """What a fit in this process gives."""
    start_s = time.process_time()
    calibration = fit()
    return Fitted(calibration, time.process_time() - start_s)


def failed(name: str, reason: str) -> Calibration:
    """The calibration of a method that came to no answer."""
    return Calibration(name=name, status=Status("not_converged", reason))
