"""Unscented Kalman filter of nine parameters from the field's strength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.models.ellipsoid import EllipsoidFit, Standardised, norm_coordinates, symmetric
from calib.numerics.kalman import Engine
from calib.numerics.unscented import filtered
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

TEMPERING = (30.0, 3.0, 1.0, 1.0)
"""Noise of each run over the recording, in units of the assumed one."""
FORGET = 100.0
"""Factor on the covariance from run to run: a run passes on where to linearise, not what it knows."""
LEAST_NIS = 1e-3
"""Noise of less than 3 % of the assumed is none: a move is then measured in that."""
MAX_MOVE = 1.0
"""Converged: the last run moves the estimate by fewer of its standard deviations."""


@dataclass(frozen=True)
class UkfCalibrator(Calibrator):
    """Offset and symmetric S by an unscented Kalman filter of a constant state on |h| = F; no attitude.

    x = (d, D),  |(I + D) m / F - d|^2 / 2 = 1 / 2 + v,  S = (I + D)^-1,  b = F S d,  D symmetric

    Quadratic in x, so that the transform's mean and variance are exact; with |h| itself, or with b in place of d, the
    filter grows sure too early and diverges. One update takes `block` samples spread over the whole recording. Four
    runs follow each other, the first with 30 times the noise. The claimed covariance is the filter's times the mean
    squared normalised innovation; "ok" needs a last run that moved by less than a standard deviation. v has the
    standard deviation `noise_fraction`. `engine`: the compiled filter, or filterpy's. [Zhang2018] ref. 1 for the
    filter, [VanDerMerwe2004] for the sigma points.
    """

    name: ClassVar[str] = "ukf"
    summary: ClassVar[str] = "unscented Kalman filter of 9 parameters from the field strength; no attitude"
    min_samples: ClassVar[int] = 40
    sequential: ClassVar[bool] = True
    noise_fraction: Positive = 3e-4
    prior_std: Positive = 0.3
    block: Count = 20
    engine: Engine = "compiled"

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        if len(recording) < self.block:
            return Status(
                "not_applicable",
                f"a block of {self.block} samples is longer than the recording, {len(recording)}: take a smaller block",
            )
        scaled = Standardised(recording.mag_nT / reference.strength_nT, np.zeros(3), reference.strength_nT)
        blocks = spread(scaled.x, self.block)
        state, covariance, history = np.zeros(9), np.eye(9) * self.prior_std**2 / FORGET, []
        for factor in TEMPERING:
            before = state
            state, covariance, nis = filtered(
                blocks, state, covariance * FORGET, factor * self.noise_fraction, self.engine
            )
            move = state - before
            history.append(float(np.sqrt(move @ np.linalg.solve(covariance * max(nis, LEAST_NIS), move))))
        noise = self.noise_fraction * float(np.sqrt(nis))
        estimate = ellipsoid_fit(state, covariance * nis, noise, tuple(history))
        return scaled.calibration(self.name, _status(history[-1], correction(state)), estimate, reference)


def spread(measured: Array, block: int) -> Array:
    """Blocks (n // block, block, 3) of measurements (n, 3), each taken evenly from the whole."""
    count = len(measured) // block
    return np.asarray(measured[: count * block].reshape(block, count, 3).transpose(1, 0, 2))


def correction(state: Array) -> Array:
    """I + D (3, 3) of a state (9,)."""
    return np.asarray(np.eye(3) + symmetric(state[3:]))


def ellipsoid_fit(state: Array, covariance: Array, noise_std: float, history: tuple[float, ...]) -> EllipsoidFit:
    """The ellipsoid of a state (9,), whose norm coordinates are (I + D, d), from its covariance (9, 9)."""
    order = np.roll(np.arange(9), -3)
    return EllipsoidFit.of_norm(
        norm_coordinates(correction(state), state[:3]), covariance[np.ix_(order, order)], noise_std, history
    )


def _status(moved: float, matrix: Array) -> Status:
    if moved > MAX_MOVE or np.linalg.eigvalsh(matrix)[0] <= 0:
        return Status(
            "not_converged",
            f"the last run over the recording still moved the estimate by {figure(moved, 2)} "
            "standard deviations: the strength alone says too little on this motion; turn about all axes",
        )
    return Status("ok")
