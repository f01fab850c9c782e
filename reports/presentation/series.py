"""Series of a diagnosis over time: measured, simulated and gap, the gap along the path, and its spectrum."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Self

import numpy as np

from diagnosis.evidence.localise import channels
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, EvidenceKind
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from validation.signals.amplitude import rms

MOST_BLOCKS, BLOCK_S = 4000, 1.0
"""Of the gap along the path: points at most, and the shortest time that one is the mean of."""
LEAST_PATH_M = 0.1
"""Extent of the positions beyond which a path is shown."""
SPECTRUM_BANDS = 300
"""Frequency bands of a spectrum at most, of equal width on a logarithmic axis."""


@dataclass(frozen=True)
class GapSeries:
    """Measured minus simulated in nT, (n, q): before_nT of the given model, after_nT of the new model.

    time_s (n,): times of samples or of block means. usable (n,): weights 0 or 1.
    """

    time_s: Array
    usable: Array
    before_nT: Array
    after_nT: Array

    @property
    def sides(self) -> dict[str, Array]:
        """Both gaps by name."""
        return {"before": self.before_nT, "after": self.after_nT}

    @property
    def largest(self) -> int:
        """Output with the largest gap before."""
        return int(np.argmax((self.before_nT**2).sum(axis=0)))

    def rms_nT(self) -> tuple[float, float]:
        """Return the root mean square of all outputs before and after, over the usable samples."""
        return rms(self.before_nT[self.usable > 0]), rms(self.after_nT[self.usable > 0])

    def thinned(self, most: int) -> Self:
        """Return the series as means over blocks of equal length, `most` blocks or fewer."""
        return self.in_blocks(block_length(len(self.time_s), most))

    def in_blocks(self, length: int) -> Self:
        """Return the series as means over blocks of `length` samples; NaN for blocks without usable samples."""
        before_nT, after_nT = (block_means(gap, length, self.usable) for gap in (self.before_nT, self.after_nT))
        usable = np.isfinite(before_nT[:, 0]).astype(float)
        return type(self)(block_means(self.time_s, length), usable, before_nT, after_nT)


@dataclass(frozen=True)
class GapAlongPath:
    """Block means of the gap with positions pos_m (m, 3) from the first, ENU; noise_nT: noise of a block's mean.

    pos_m: None if not recorded, or within LEAST_PATH_M.
    """

    gap: GapSeries
    pos_m: Array | None
    noise_nT: float


@dataclass(frozen=True)
class AmplitudeDensity:
    """Amplitude density of the gap before and after (m,) in nT/√Hz by frequency; level: white noise of a sample."""

    frequency_Hz: Array
    before: Array
    after: Array
    level: float


@dataclass(frozen=True)
class DiagnosisSeries:
    """Series of a diagnosis at every sample (n,), in nT; outputs (q): names of the compared components.

    vector: compared in body axes, q = 3. Without attitude q = 1: field strength. With roll and pitch q = 2: field
    strength and dip, the dip as angle times strength. mag_nT (n, 3), measured_nT (n, q); simulated: `before` and
    `after`, the given model and the new model along the measured motion. residual: iron refitted. difference: models
    without refit; without attitude the residual. hidden: a refit of the iron would absorb the cause. channels (n,):
    followed by the gap. att_q (n, 4), pos_m (n, 3): where recorded.
    """

    vector: bool
    outputs: tuple[str, ...]
    time_s: Array
    mag_nT: Array
    measured_nT: Array
    simulated: dict[str, Array]
    residual: GapSeries
    difference: GapSeries
    hidden: bool
    channels: dict[str, Array]
    att_q: Array | None
    pos_m: Array | None
    path: GapAlongPath
    spectrum: AmplitudeDensity

    @property
    def displayed(self) -> GapSeries:
        """Gap to be shown: with iron refitted, or without where the refit hides the cause."""
        return self.difference if self.hidden else self.residual

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Self:
        """Compute the series; the new model is simulated along the measured motion."""
        problem = diagnosis.problem
        recording, vector = problem.recording, problem.mode == "vector"
        residual = GapSeries(problem.state.time_s, problem.usable, diagnosis.before_nT, diagnosis.after_nT)
        measured_nT, simulated = _compared(diagnosis)
        gaps = (measured_nT - side for side in simulated.values())
        difference = GapSeries(residual.time_s, residual.usable, *gaps) if vector else residual
        hidden = vector and any(cause.kind is EvidenceKind.IRON for cause in diagnosis.named)
        every, pos = dict(channels(problem)), recording.pos_enu_m
        pos_m = None if pos is None else np.asarray(pos - pos[0])  # map coordinates exceed single precision
        return cls(
            vector,
            tuple(problem.outputs),
            residual.time_s,
            recording.mag_nT,
            measured_nT,
            simulated,
            residual,
            difference,
            hidden,
            {name: every[name] for name, _, _ in diagnosis.where if name in every},
            recording.att_q,
            pos_m,
            _along_path(problem, difference if hidden else residual, pos_m),
            _spectrum(problem, diagnosis.before_nT, diagnosis.after_nT),
        )


def _compared(diagnosis: Diagnosis) -> tuple[Array, dict[str, Array]]:
    """Return the measured values, and the simulated values of both models."""
    problem = diagnosis.problem
    if problem.mode == "vector":
        smooth = [effect for effect in diagnosis.model.chain() if not effect.traits.converter]
        simulated = {"before": problem.predicted_nT, "after": apply_deterministic(smooth, problem.state)[0]}
        return problem.recording.mag_nT, simulated
    given_nT = np.linalg.norm(problem.state.field_nT, axis=1, keepdims=True)
    if problem.level is not None:
        given_nT = np.hstack([given_nT, given_nT * problem.level.dip_rad[:, None]])
    measured_nT = given_nT + problem.target * problem.sigma_nT
    return measured_nT, {"before": measured_nT - diagnosis.before_nT, "after": measured_nT - diagnosis.after_nT}


def _along_path(problem: LinearProblem, gap: GapSeries, pos_m: Array | None) -> GapAlongPath:
    """Return the gap in blocks of BLOCK_S or longer."""
    length = max(round(BLOCK_S / problem.state.interval_s), block_length(len(gap.time_s), MOST_BLOCKS))
    places = None if pos_m is None else block_means(pos_m, length)
    moves = places is not None and np.ptp(places, axis=0).max() > LEAST_PATH_M
    noise_nT = float(np.linalg.norm(problem.sigma_nT)) / np.sqrt(length)
    return GapAlongPath(gap.in_blocks(length), places if moves else None, noise_nT)


def _spectrum(problem: LinearProblem, *gaps: Array) -> AmplitudeDensity:
    n, interval_s = len(gaps[0]), problem.state.interval_s
    frequency_Hz = np.fft.rfftfreq(n, interval_s)
    edges = np.unique(np.geomspace(1, len(frequency_Hz) - 1, SPECTRUM_BANDS).astype(int))
    bands = [slice(*ends) for ends in itertools.pairwise(edges)]
    spectra = [np.abs(np.fft.rfft(gap - gap.mean(axis=0), axis=0)) ** 2 for gap in gaps]
    powers = [power.mean(axis=1) * 2 * interval_s / n for power in spectra]
    middle, before, after = (np.array([of[band].mean() for band in bands]) for of in (frequency_Hz, *powers))
    level = float(np.sqrt((problem.sigma_nT**2).mean() * 2 * interval_s))
    return AmplitudeDensity(middle, np.sqrt(before), np.sqrt(after), level)


def block_length(n: int, most: int) -> int:
    """Return the number of samples in a block, for at most `most` blocks over n samples."""
    return max(1, -(-n // most))


def block_means(values: Array, length: int, usable: Array | None = None) -> Array:
    """Return means (m,) or (m, k) of values (n,) or (n, k) over blocks of `length` samples, the last perhaps shorter.

    usable (n,): weights 0 or 1; a block without usable samples is NaN.
    """
    starts = np.arange(0, len(values), length)
    weight = np.ones(len(values)) if usable is None else usable
    shape = (-1, *[1] * (values.ndim - 1))
    count = np.add.reduceat(weight, starts).reshape(shape)
    total = np.add.reduceat(np.where(weight.reshape(shape) > 0, values, 0.0), starts, axis=0)
    return np.asarray(total / np.where(count > 0, count, np.nan))
