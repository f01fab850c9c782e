"""Where the strength that a calibration leaves differs from the field's: by phase of the motion, and by channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Calibration, Reference
from recordings import Recording
from recordings.assemble import scalars_of
from recordings.channels import may_be_cause
from scenarios.arrays import Array

LEAST_SHARE = 0.02
"""Share of the residual's variance below which a channel is not listed."""
BY_CHANCE = 0.01
"""Share of the shifts in time that may reach a listed channel's share."""
SHIFT = 0.1
"""Least shift, in lengths of the recording."""


@dataclass(frozen=True)
class PhaseResidual:
    """Mean and rms of |h| - F in a phase, nT, over a number of samples."""

    phase: str
    samples: int
    mean_nT: float
    rms_nT: float


@dataclass(frozen=True)
class ChannelResidual:
    """Share (0 to 1) of the variance of |h| - F that goes with a channel in proportion, and the slope, nT a unit."""

    channel: str
    share: float
    slope_nT: float


def strength_residual(calibration: Calibration, recording: Recording, reference: Reference) -> Array:
    """Return |h| - F of the corrected field h, (n,), nT."""
    return np.asarray(np.linalg.norm(calibration.apply(recording), axis=1) - reference.strength_nT)


def by_phase(residual_nT: Array, recording: Recording) -> tuple[PhaseResidual, ...]:
    """Return the residual (n,) of each phase, in the order of time; empty for fewer than two phases."""
    if recording.phase is None or len(set(recording.phase)) < 2:
        return ()
    parts = ((str(name), residual_nT[recording.phase == name]) for name in dict.fromkeys(recording.phase))
    return tuple(
        PhaseResidual(name, len(part), float(part.mean()), float(np.sqrt(np.mean(part**2)))) for name, part in parts
    )


def by_channel(residual_nT: Array, recording: Recording) -> tuple[ChannelResidual, ...]:
    """Return the channels that the residual (n,) goes with, largest share first.

    share = corr(r, c)^2. Two slow courses go together by chance, so a channel counts only where the innovations
    r_i - rho r_i-1 and c_i - rho c_i-1, rho the residual's correlation from sample to sample, go together too: more
    than when one of them is shifted by more than SHIFT of the recording, in all but BY_CHANCE of the shifts.
    """
    causes = ((name, values) for name, values in scalars_of(recording).items() if may_be_cause(name))
    found = (_followed(residual_nT, name, values) for name, values in causes)
    return tuple(sorted((one for one in found if one is not None), key=lambda one: -one.share))


def _followed(residual_nT: Array, name: str, values: Array) -> ChannelResidual | None:
    """Return a channel that the residual goes with, None for another."""
    spread, size = float(np.std(values)), float(np.std(residual_nT))
    if not (np.isfinite(spread) and spread > 0 and size > 0):
        return None
    r, c = (residual_nT - residual_nT.mean()) / size, (values - values.mean()) / spread
    slope, lasting = float(np.mean(r * c)), float(np.mean(r[1:] * r[:-1]))
    if slope**2 < LEAST_SHARE or _chance(r[1:] - lasting * r[:-1], c[1:] - lasting * c[:-1]) > BY_CHANCE:
        return None
    return ChannelResidual(name, slope**2, slope * size / spread)


def _chance(r: Array, c: Array) -> float:
    """Return the share of the shifts at which two series (n,) go together at least as much as unshifted."""
    every = np.fft.irfft(np.fft.rfft(r) * np.conj(np.fft.rfft(c)), len(r)) ** 2
    margin = max(1, int(SHIFT * len(r)))
    return float(np.mean(every[margin:-margin] >= every[0])) if len(r) > 2 * margin else 1.0
