"""Kalman filter of the 21 parameters of the vector model, in the paper's own scaling."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from calib.base import Calibrator
from calib.models.vector import NAMES, VectorData, calibration
from calib.observability import motion_status
from calib.reference import Reference
from calib.result import Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]
Adapt = Callable[[list[float], float, float], float]
"""(innovation r, tr(P_r), R) of a sample, nT and nT^2, to the R of the next sample."""
MAX_PRIOR_SHARE = 0.01
"""Converged: the prior weighs less than this in every direction of the state."""
MAX_HISTORY = 200
IDENTITY_3 = np.eye(3)


@dataclass(frozen=True)
class KalmanSettings:
    """The filter of a constant state: x0 = (0 x3, a x9, b x9), P0 = p I, Q = q I, R = r I. Defaults: [Li2017] table 1.

    offset_unit_nT: unit of T_p in the state; q a sample; r in nT^2.
    """

    offset_unit_nT: float = 1.0
    start_induced: float = 0.01
    start_eddy_s: float = 0.02
    prior_variance: float = 100.0
    state_variance: float = 1e-5
    noise_variance_nT2: float = 1e-3


@dataclass(frozen=True, eq=False)
class Track:
    """The filter along the samples: state (n, 21) and its variance (n, 21), scaled to nT, 1 and s; covariance (21, 21)
    of the last; squared normalised innovation nis (n,), three degrees of freedom; noise_variance_nT2 R (n,); ratio ROR
    (n,), tr of the innovations' mean square in a window over tr of the predicted, NaN before the window is full.
    """

    state: Array
    variance: Array
    covariance: Array
    nis: Array
    noise_variance_nT2: Array
    ratio: Array

    @property
    def variance_factor(self) -> float:
        """Mean NIS over its expectation: the common scale of P0, Q and R that the innovations show.

        The gain depends on the ratios of P0, Q and R alone, so this scale changes no estimate, only what it claims.
        """
        return float(self.nis.mean()) / 3.0


def track(data: VectorData, settings: KalmanSettings, window: int = 50, adapt: Adapt | None = None) -> Track:
    """Run filterpy's filter over the data.

    K = P H^T (H P H^T + R)^-1,  x += K (y - H x),  P = (I - K H) P (I - K H)^T + K R K^T,  P += Q  ([Li2017] 2.1)

    The state is constant, so predicting leaves x and adds Q to P; filterpy's `predict` would multiply P by F = I twice
    for the same numbers. P is made symmetric after each step: with P0 H H^T / R near 1e14 rounding otherwise makes it
    indefinite.
    """
    # Imported here: filterpy takes more than a second that other methods need not wait for.
    from filterpy.kalman import KalmanFilter

    filter_ = KalmanFilter(dim_x=21, dim_z=3)
    filter_.inv = inverse_3x3
    filter_.x = np.concatenate((np.zeros(3), np.full(9, settings.start_induced), np.full(9, settings.start_eddy_s)))
    filter_.P, Q = np.eye(21) * settings.prior_variance, np.eye(21) * settings.state_variance
    noise = settings.noise_variance_nT2
    filter_.R = IDENTITY_3 * noise
    n = len(data.field_nT)
    shapes = ((21,), (21,), (3,), (3, 3), (), ())
    state, variance, innovation, inverse, predicted_nT2, noise_nT2 = (np.empty((n, *shape)) for shape in shapes)
    for k, (H, y) in enumerate(zip(data.observation(settings.offset_unit_nT), data.difference_nT, strict=True)):
        filter_.P += Q
        filter_.update(y, H=H)
        P, S, r = filter_.P, filter_.S, filter_.y
        symmetrise(P)
        state[k], variance[k], innovation[k], inverse[k] = filter_.x, P.diagonal(), r, filter_.SI
        predicted = float(S[0, 0] + S[1, 1] + S[2, 2])
        predicted_nT2[k], noise_nT2[k] = predicted, noise
        if adapt is not None and (changed := adapt(r.tolist(), predicted, noise)) != noise:
            noise = changed
            filter_.R = IDENTITY_3 * noise
    unit = np.ones(21)
    unit[:3] = settings.offset_unit_nT
    return Track(
        state * unit,
        variance * unit**2,
        filter_.P * np.outer(unit, unit),
        np.einsum("ni,nij,nj->n", innovation, inverse, innovation),
        noise_nT2,
        innovation_ratio(innovation, predicted_nT2, window),
    )


@njit(cache=True)
def symmetrise(P: Array) -> None:
    """P = (P + P^T) / 2 in place."""
    for i in range(len(P)):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])


def innovation_ratio(innovation: Array, predicted_nT2: Array, window: int) -> Array:
    """ROR (n,) = tr(C_r) / tr(P_r), C_r the mean of r r^T over the last `window` innovations ([Li2017] eq. 11-15)."""
    total = np.cumsum((innovation**2).sum(axis=1))
    total[window:] -= total[:-window].copy()
    ratio = total / window / predicted_nT2
    ratio[: window - 1] = np.nan
    return np.asarray(ratio)


def inverse_3x3(S: Array) -> Array:
    """Inverse of a 3x3 matrix by LAPACK's own call, a third of the time of numpy's wrapper around the same one."""
    _, _, inverse, info = dgesv(S, IDENTITY_3)
    if info:
        raise np.linalg.LinAlgError("the innovation's covariance is singular")
    return np.asarray(inverse)


@dataclass(frozen=True)
class VectorFilter(Calibrator):
    """T_p, A and B by a Kalman filter of a constant state, sample by sample; a subclass says how R adapts.

    T_m - T = H x + v,  H = [I3 | T_3x9 | dT_3x9],  x = (T_p, A, B),  x_k = x_k-1 + w  ([Li2017] eq. 1 to 9, table 1)

    The claimed covariance is the filter's times `Track.variance_factor`.
    """

    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector")
    min_samples: ClassVar[int] = 21
    sequential: ClassVar[bool] = True
    tolerance_nT: ClassVar[float] = 5.0
    tolerance_matrix: ClassVar[float] = 2e-4
    unit_free: ClassVar[bool] = False
    settings: KalmanSettings = KalmanSettings()
    attitude_std_rad: float = 3.5e-4

    @abstractmethod
    def adapt(self) -> Adapt | None:
        """What gives the next sample's R, for one run; None where R stays."""

    @final
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        data = VectorData.of(recording, reference)
        flat = motion_status(data.field_nT, reference.strength_nT, self.attitude_std_rad)
        if flat is not None:
            return flat
        steps = track(data, self.settings, adapt=self.adapt())
        extra = {"nis_mean": float(steps.nis.mean()), "noise_variance_nT2": float(steps.noise_variance_nT2[-1])}
        return calibration(
            self.name,
            _status(steps, self.settings),
            steps.state[-1],
            steps.variance_factor * steps.covariance,
            extra,
            _history(steps, self.settings),
        )


@dataclass(frozen=True)
class KalmanCalibrator(VectorFilter):
    """The filter as [Li2017] prints it first, with T_p in nT.

    T_p in nT has a prior standard deviation of 10 nT beside columns of 10^4: it practically stays where it began, as
    the paper finds; the status says so.
    """

    name: ClassVar[str] = "kalman"
    summary: ClassVar[str] = "Kalman filter of 21 parameters, T_p in nT: the paper's baseline, whose T_p hardly moves"
    recovers: ClassVar[tuple[str, ...]] = ()

    def adapt(self) -> None:
        """R stays."""


def _scaled(settings: KalmanSettings) -> Array:
    """Prior variance (21,) in nT^2, 1 and s^2."""
    unit = np.ones(21)
    unit[:3] = settings.offset_unit_nT
    return settings.prior_variance * unit**2


def _status(steps: Track, settings: KalmanSettings) -> Status:
    root = np.sqrt(_scaled(settings))
    values, vectors = np.linalg.eigh(steps.covariance / np.outer(root, root))
    if values[0] < 0 or steps.nis.min() < 0:
        return Status("not_converged", "the covariance is no longer positive definite: raise noise_variance_nT2")
    if values[-1] <= MAX_PRIOR_SHARE:
        return Status("ok")
    worst = NAMES[int(np.argmax(np.abs(vectors[:, -1])))]
    return Status(
        "not_converged",
        f"the covariance has not come down: the start value still weighs {values[-1]:.2g} "
        f"(limit {MAX_PRIOR_SHARE:g}), most in {worst}; record longer, turn about more axes, lower "
        "state_variance, or use kalman_rescaled where T_p is what stays behind",
    )


def _history(steps: Track, settings: KalmanSettings) -> tuple[float, ...]:
    """Largest variance over its start, at no more than MAX_HISTORY samples, the last among them."""
    share = (steps.variance / _scaled(settings)).max(axis=1)
    picked = np.unique(np.linspace(0, len(share) - 1, min(MAX_HISTORY, len(share))).round().astype(int))
    return tuple(share[picked].tolist())
