"""Anybody's calibrator: a description that can be sent to another process, and that fits there."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

import calib
from calib import Calibration, Reference, Status
from sim.dataset import Recording


@dataclass(frozen=True)
class Fitted:
    """A calibration, and the processor time that it took in whatever processes, s."""

    calibration: Calibration
    cpu_s: float


class Method(Protocol):
    """How a candidate fits; it holds names and settings alone, and loads what it needs when it is called."""

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Fitted:
        """The calibration of one recording."""


@dataclass(frozen=True)
class Candidate:
    """A calibrator that takes part: small, frozen, and the same in every process.

    `attitude_free`: it uses no attitude, so that its scores leave out the rotation which the field's strength cannot
    tell. `whole_array`: it takes all sensors of an array at once.
    """

    name: str
    method: Method
    attitude_free: bool
    whole_array: bool = False

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Calibration:
        """The calibration of one recording; as `timed`."""
        return self.timed(recording, reference, rng).calibration

    def timed(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Fitted:
        """The calibration and its processor time; rng (default: seed 0) matters to stochastic methods only.

        Whatever a calibrator raises becomes its status, not converged, with the message as the reason.
        """
        start_s = time.process_time()
        try:
            return self.method.fit(recording, reference, rng or np.random.default_rng(0))
        except Exception as error:
            status = Status("not_converged", f"{type(error).__name__}: {error}")
            return Fitted(Calibration(name=self.name, status=status), time.process_time() - start_s)


@dataclass(frozen=True)
class BuiltIn:
    """One of `calib.CALIBRATORS`, with its default settings."""

    name: str

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Fitted:
        """The calibration of one recording, in this process."""
        start_s = time.process_time()
        found = calib.get(self.name).fit(recording, reference, rng)
        return Fitted(found, time.process_time() - start_s)


def candidates(with_: Sequence[str]) -> tuple[Candidate, ...]:
    """The calibrators of these names, one of each; InputError lists those there are."""
    return tuple(_built_in(name) for name in dict.fromkeys(with_))


def _built_in(name: str) -> Candidate:
    method = calib.get(name)
    return Candidate(name, BuiltIn(name), "attitude" not in method.needs, method.whole_array)
