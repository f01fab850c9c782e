"""Base of maximum likelihood with directions linked by the gyro: starts, minimum, noise ratio, calibration."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calib.acceptance import CorrectedField, measured, residual_of, widened
from calib.base import Calibrator
from calib.models.chained import Chained, Linear
from calib.models.ellipsoid import FULL_SLOTS, SYMMETRIC_NAMES, SYMMETRIC_SLOTS, UPPER
from calib.models.linked import LEAST_NOISE, LinkedEstimate, LinkedSamples, mean_rates, steps
from calib.models.linked_noise import likeliest_ratio
from calib.models.linked_start import starts
from calib.models.response import Response
from calib.models.vector import SOFT_IRON_NAMES
from calib.numerics.damped import Minimum, minimised
from calib.numerics.noise import white_noise_std
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

LEAST_GYRO_RAD_S = 1e-6
"""Noise of the gyro taken at first for one that shows less."""
RATIO_SETTLED = 0.02
"""Change of the logarithm of the ratio of the noises at which it has settled: no more than thousands of links tell."""
MOST_TURN_DEG = 20.0
"""An "ok" says so where gyro and magnetometer are turned against each other by more: no mounting, wrong axes."""
BIAS_NAMES = ("gyro_bias_x_rad_s", "gyro_bias_y_rad_s", "gyro_bias_z_rad_s")


@dataclass(frozen=True, eq=False)
class LinkedFit:
    """A minimum, the noises of magnetometer and gyro at the minimum, the history, and whether the fit has settled.

    told : further results, by name
    """

    chain: Chained[Any]
    found: Minimum[Any]
    gyro_std_rad_s: float
    history: tuple[float, ...]
    settled: bool
    told: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class GyroLinked(Calibrator):
    """The field's direction carried from sample to sample by the gyro; a subclass adds further measurements.

    Offset, S and the gyro's bias of greatest likelihood with all directions, the ratio of the noises fitted
    (`gyro_std_rad_s` None) or stated. `aligned` True: S symmetric in the gyro's axes.
    """

    min_samples: ClassVar[int] = 30
    sequential: ClassVar[bool] = True
    carries: ClassVar[bool] = True
    iterations: Count = 40
    rounds: Count = 10
    tolerance: Positive = 0.01
    gyro_std_rad_s: Positive | None = None
    aligned: bool = False

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        link = self._link(recording, reference.strength_nT)
        fit = self._refined(self._rounds(link, self._first(link)), recording, reference)
        if isinstance(fit, Status):
            return fit
        status = Status.settled(
            fit.settled,
            f"after {len(fit.history)} steps estimate (by {figure(fit.history[-1], 2)} standard deviations) or "
            "noise still "
            "move: record longer, turn about more axes",
        )
        status = replace(status, reason=status.reason or _caveat(fit.found))
        found = self._calibration(fit, status, reference)
        seen = measured(recording)
        residual_nT = residual_of(found, seen, reference, vector=False)
        response = self._response(fit, reference.strength_nT).without(link.absent)
        field = CorrectedField(found, seen, reference.strength_nT)
        return widened(found, residual_nT, field, reference, vector=False, response=response)

    @property
    @abstractmethod
    def _beside(self) -> tuple[str, ...]:
        """Names of the parameters between S and the gyro's bias."""

    @abstractmethod
    def _refined(self, fit: LinkedFit, recording: Recording, reference: Reference) -> LinkedFit | Status:
        """The fit extended by a subclass; a status where the extension fails."""

    def _link(self, recording: Recording, strength_nT: float) -> LinkedSamples:
        """The recording in order of time, with the noises that it shows by itself."""
        assert recording.gyro_rad_s is not None
        order = np.argsort(recording.time_s, kind="stable")
        x, absent = bridged(recording.mag_nT[order] / strength_nT)
        rate_rad_s = recording.gyro_rad_s[order]
        noise = max(rms(white_noise_std(x)), LEAST_NOISE)
        gyro_rad_s = self.gyro_std_rad_s or max(rms(white_noise_std(rate_rad_s)), LEAST_GYRO_RAD_S)
        slots, step_s = SYMMETRIC_SLOTS if self.aligned else FULL_SLOTS, steps(recording.time_s[order])
        return LinkedSamples(x, mean_rates(rate_rad_s, step_s), step_s, slots, gyro_rad_s / noise, absent)

    def _first(self, link: LinkedSamples) -> Minimum[Linear[LinkedEstimate]]:
        """The best minimum of the starts, tried in order of cost until the first that settles."""
        tried: list[Minimum[Linear[LinkedEstimate]]] = []
        for start in sorted((link.settled(start) for start in starts(link)), key=lambda start: start.cost):
            tried.append(minimised(link, start, self.iterations, self.tolerance))
            if tried[-1].settled:
                break
        return min(tried, key=lambda one: one.normal.cost)

    def _rounds(self, link: LinkedSamples, found: Minimum[Linear[LinkedEstimate]]) -> LinkedFit:
        """Minimum and ratio of the noises in turn, until the ratio settles."""
        history, change = found.history, np.inf
        for _ in range(self.rounds):
            before = link.ratio
            link = link.with_ratio(self._ratio(link, found))
            found = minimised(link, link.settled(found.point.estimate), self.iterations, self.tolerance)
            history, change = history + found.history, abs(float(np.log(link.ratio / before)))
            if change < RATIO_SETTLED or not found.settled:
                break
        gyro_rad_s = link.ratio * float(np.sqrt(found.normal.variance))
        return LinkedFit(link, found, gyro_rad_s, history, found.settled and change < RATIO_SETTLED)

    def _ratio(self, link: LinkedSamples, found: Minimum[Linear[LinkedEstimate]]) -> float:
        if self.gyro_std_rad_s is None:
            return likeliest_ratio(link, found.point)
        return self.gyro_std_rad_s / float(np.sqrt(found.normal.variance))

    def _response(self, fit: LinkedFit, strength_nT: float) -> Response:
        """How each measurement, nT, moves offset, nT, S and what else is found."""
        per_nT = np.where(np.arange(fit.chain.count) < len(OFFSET_NAMES), 1.0, 1.0 / strength_nT)
        return Response(per_nT[:, None] * fit.chain.response(fit.found.point), self._names)

    @property
    def _names(self) -> tuple[str, ...]:
        return (*OFFSET_NAMES, *(SYMMETRIC_NAMES if self.aligned else SOFT_IRON_NAMES), *self._beside, *BIAS_NAMES)

    def _calibration(self, fit: LinkedFit, status: Status, reference: Reference) -> Calibration:
        """The minimum in nT."""
        e, normal = fit.found.point.estimate, fit.found.normal
        noise, names = float(np.sqrt(normal.variance)), self._names
        entries = e.root[UPPER] if self.aligned else e.root.ravel()
        values = np.concatenate((reference.strength_nT * e.centre, entries, e.beside, e.bias_rad_s))
        units = np.where(np.arange(len(names)) < len(OFFSET_NAMES), reference.strength_nT, 1.0) / normal.scale
        inverse = np.linalg.inv(normal.square / np.outer(normal.scale, normal.scale))
        told = {"noise_std_nT": noise * reference.strength_nT, "gyro_noise_std_rad_s": fit.gyro_std_rad_s} | fit.told
        return Calibration(
            name=self.name,
            status=status,
            offset_nT=values[:3].copy(),
            matrix=np.asarray(np.linalg.inv(e.root)),
            parameters=dict(zip(names, values.tolist(), strict=True)) | told,
            covariance=np.asarray(noise**2 * inverse * np.outer(units, units)),
            covariance_names=names,
            history=fit.history,
        )


def bridged(x: Array) -> tuple[Array, NDArray[np.intp]]:
    """Measurements x (n, 3) with missing rows (NaN) interpolated, and the indices of these rows."""
    missing = np.isnan(x[:, 0])
    absent = np.flatnonzero(missing)
    if not len(absent):
        return x, absent
    seen = np.flatnonzero(~missing)
    filled = [np.interp(np.arange(len(x)), seen, column[seen]) for column in x.T]
    return np.column_stack(filled), absent


def rms(std: Array) -> float:
    return float(np.sqrt(np.mean(std**2)))


def _caveat(found: Minimum[Any]) -> str:
    """Caveat of an "ok" with a large angle between the axes of gyro and magnetometer; empty for a small angle."""
    left, _, right = np.linalg.svd(found.point.estimate.root)
    turn_deg = float(np.degrees(np.arccos(np.clip((np.trace(left @ right) - 1.0) / 2.0, -1.0, 1.0))))
    if turn_deg <= MOST_TURN_DEG:
        return ""
    return (
        f"the gyro's axes are turned by {turn_deg:.0f} degrees from the magnetometer's, and the corrected field is "
        "along the gyro's: check how both are mapped"
    )
