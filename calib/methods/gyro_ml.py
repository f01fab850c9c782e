"""Maximum likelihood with directions linked by the gyro, for vehicles that cannot tumble."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calib.base import Calibrator
from calib.judgement import residual_of, widened
from calib.models.ellipsoid import SLOTS, SYMMETRIC_NAMES, UPPER
from calib.models.linked import LEAST_NOISE, Linear, Link, steps
from calib.models.linked_noise import likeliest_ratio
from calib.models.linked_start import starts
from calib.models.response import Response
from calib.models.vector import SOFT_IRON_NAMES
from calib.numerics.damped import Minimum, minimised
from calib.numerics.noise import white_noise_std
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from calib.settings import Count, Positive
from sim.dataset import Recording

Array = NDArray[np.float64]
LEAST_GYRO_RAD_S = 1e-6
"""Noise of the gyro taken at first for one that shows less."""
RATIO_SETTLED = 0.02
"""Change of the logarithm of the ratio of the noises at which it has settled: no more than thousands of links tell."""
MOST_TURN_DEG = 20.0
"""An "ok" says so where gyro and magnetometer are turned against each other by more: no mounting, wrong axes."""
FULL, SYMMETRIC = np.eye(9).reshape(9, 3, 3), np.ascontiguousarray(SLOTS[:, :6, :3].transpose(1, 0, 2))
"""dS / d its entries."""
BIAS_NAMES = ("gyro_bias_x_rad_s", "gyro_bias_y_rad_s", "gyro_bias_z_rad_s")


@dataclass(frozen=True)
class GyroMl(Calibrator):
    """Offset and S of greatest likelihood, the field's direction carried from sample to sample by the gyro.

    m_i = S F u_i + b + n_i,  u_(i+1) = exp(-[(omega_i - beta) dt_i]x) u_i + w_i,  |u_i| = 1

    All directions u_i, b, S and the gyro's bias beta at once, by damped Gauss-Newton, in time in proportion to the
    samples: the directions are eliminated along the chain and found again backwards. omega_i is the mean of the rates
    at both ends of a step; a gap in the recording cuts the chain. S has nine entries, in the gyro's axes: with rates
    about changing axes the gyro tells the sensor's turn against it, at hardly any cost to the offset.

    n is white, and w white of standard deviation `gyro_std_rad_s` dt_i. The noise of n is fitted, that of the gyro too
    where it is None: the ratio of both is the one under which what the fit leaves is most likely
    [PattersonThompson1971], so that a gyro that is worse than its white noise counts for less.
    Started from the sphere, the algebraic ellipsoid and the linear fit of T m_j - d = R_ij (T m_i - d) along the gyro's
    rotations R_ij, each turned to where the gyro's axes are seen to be, in order of cost until one settles.
    Claimed covariance: inverse information, the directions and the bias not known. [RauchTungStriebel1965]

    `aligned` True: S symmetric, the gyro along the axes in which it is.
    """

    name: ClassVar[str] = "gyro_ml"
    summary: ClassVar[str] = "maximum likelihood with directions linked by the gyro, for vehicles that cannot tumble"
    needs: ClassVar[tuple[str, ...]] = ("gyro",)
    min_samples: ClassVar[int] = 30
    sequential: ClassVar[bool] = True
    iterations: Count = 40
    rounds: Count = 10
    tolerance: Positive = 0.01
    gyro_std_rad_s: Positive | None = None
    aligned: bool = False

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        link = self._link(recording, reference.strength_nT)
        link, found, history, settled = self._rounds(link, self._first(link))
        status = Status.settled(
            settled,
            f"after {len(history)} steps estimate (by {history[-1]:.2g} standard deviations) or gyro's noise still "
            "move: record longer, turn about more axes",
        )
        fit = self._calibration(link, found, replace(status, reason=status.reason or _caveat(found)), reference)
        fit = replace(fit, history=history)
        residual_nT = residual_of(fit, recording, reference, vector=False)
        response = self._response(link, found, reference.strength_nT)
        return widened(fit, residual_nT, recording, reference, vector=False, response=response)

    def _link(self, recording: Recording, strength_nT: float) -> Link:
        """The recording in order of time, with the noises that it shows by itself."""
        assert recording.gyro_rad_s is not None
        order = np.argsort(recording.time_s, kind="stable")
        x, rate_rad_s = recording.mag_nT[order] / strength_nT, recording.gyro_rad_s[order]
        noise = max(_rms(white_noise_std(x)), LEAST_NOISE)
        gyro_rad_s = self.gyro_std_rad_s or max(_rms(white_noise_std(rate_rad_s)), LEAST_GYRO_RAD_S)
        slots = SYMMETRIC if self.aligned else FULL
        return Link(
            x, (rate_rad_s[1:] + rate_rad_s[:-1]) / 2, steps(recording.time_s[order]), slots, gyro_rad_s / noise
        )

    def _first(self, link: Link) -> Minimum[Linear]:
        """The best minimum from the starts, in order of their cost until one settles."""
        tried: list[Minimum[Linear]] = []
        for start in sorted((link.settled(start) for start in starts(link)), key=lambda start: start.cost):
            tried.append(minimised(link, start, self.iterations, self.tolerance))
            if tried[-1].settled:
                break
        return min(tried, key=lambda one: one.normal.cost)

    def _rounds(self, link: Link, found: Minimum[Linear]) -> tuple[Link, Minimum[Linear], tuple[float, ...], bool]:
        """Minimum and ratio of the noises in turn, until the ratio settles; the lengths of all steps."""
        history, change = found.history, np.inf
        for _ in range(self.rounds):
            before = link.ratio
            link = link.with_ratio(self._ratio(link, found))
            found = minimised(link, link.settled(found.point.estimate), self.iterations, self.tolerance)
            history, change = history + found.history, abs(float(np.log(link.ratio / before)))
            if change < RATIO_SETTLED or not found.settled:
                break
        return link, found, history, found.settled and change < RATIO_SETTLED

    def _ratio(self, link: Link, found: Minimum[Linear]) -> float:
        if self.gyro_std_rad_s is None:
            return likeliest_ratio(link, found.point)
        return self.gyro_std_rad_s / float(np.sqrt(found.normal.variance))

    def _response(self, link: Link, found: Minimum[Linear], strength_nT: float) -> Response:
        """How each measurement, nT, moves offset, nT, S and bias."""
        per_nT = np.where(np.arange(link.count) < len(OFFSET_NAMES), 1.0, 1.0 / strength_nT)
        return Response(per_nT[:, None] * link.response(found.point), self._names)

    @property
    def _names(self) -> tuple[str, ...]:
        return (*OFFSET_NAMES, *(SYMMETRIC_NAMES if self.aligned else SOFT_IRON_NAMES), *BIAS_NAMES)

    def _calibration(self, link: Link, found: Minimum[Linear], status: Status, reference: Reference) -> Calibration:
        """The minimum in nT."""
        e, noise = found.point.estimate, float(np.sqrt(found.normal.variance))
        entries = e.root[UPPER] if self.aligned else e.root.ravel()
        names = self._names
        values = np.concatenate((reference.strength_nT * e.centre, entries, e.bias_rad_s))
        units = np.where(np.arange(len(names)) < len(OFFSET_NAMES), reference.strength_nT, 1.0) / found.normal.scale
        inverse = np.linalg.inv(found.normal.square / np.outer(found.normal.scale, found.normal.scale))
        told = {"noise_std_nT": noise * reference.strength_nT, "gyro_noise_std_rad_s": noise * link.ratio}
        return Calibration(
            name=self.name,
            status=status,
            offset_nT=values[:3].copy(),
            matrix=np.asarray(np.linalg.inv(e.root)),
            parameters=dict(zip(names, values.tolist(), strict=True)) | told,
            covariance=np.asarray(noise**2 * inverse * np.outer(units, units)),
            covariance_names=names,
        )


def _rms(std: Array) -> float:
    return float(np.sqrt(np.mean(std**2)))


def _caveat(found: Minimum[Linear]) -> str:
    """What an "ok" is to say of axes that are not what they are taken for; nothing where they are."""
    left, _, right = np.linalg.svd(found.point.estimate.root)
    turn_deg = float(np.degrees(np.arccos(np.clip((np.trace(left @ right) - 1.0) / 2.0, -1.0, 1.0))))
    if turn_deg <= MOST_TURN_DEG:
        return ""
    return (
        f"the gyro's axes are turned by {turn_deg:.0f} degrees from the magnetometer's, and the corrected field is "
        "along the gyro's: check how both are mapped"
    )
