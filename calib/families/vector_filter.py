"""Kalman filters of the 21 parameters of the vector model: settings, filter, status."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from calib.base import Calibrator
from calib.models.vector import NAMES, VectorData, calibration
from calib.numerics.kalman import STEADY, Engine, NoiseRule, filtered
from calib.observability import rounded_sizes
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from calib.settings import NotNegative, Positive, check
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

MAX_PRIOR_SHARE = 0.01
"""Converged: the prior weighs less than this in every direction of the state."""
MAX_HISTORY = 200
MICROTESLA_NT = 1000.0
"""The unit of T_p in which [Li2017]'s prior leaves it free (eq. 10)."""


@dataclass(frozen=True)
class KalmanSettings:
    """The filter of a constant state: x0 = (0 x3, a x9, b x9), P0 = p I, Q = q I, R = r I. Defaults: [Li2017] table 1.

    offset_unit_nT: unit of T_p in the state; q a sample; r in nT^2.
    """

    offset_unit_nT: Positive = 1.0
    start_induced: float = 0.01
    start_eddy_s: float = 0.02
    prior_variance: Positive = 100.0
    state_variance: NotNegative = 1e-5
    noise_variance_nT2: Positive = 1e-3

    def __post_init__(self) -> None:
        """Raise InputError where a value is not what its type allows."""
        check(self, "settings")

    @property
    def start(self) -> Array:
        """State (21,) at the beginning."""
        return np.concatenate((np.zeros(3), np.full(9, self.start_induced), np.full(9, self.start_eddy_s)))

    @property
    def unit(self) -> Array:
        """Units (21,) of the state in nT, 1 and s."""
        return np.array([self.offset_unit_nT] * 3 + [1.0] * 18)


@dataclass(frozen=True, eq=False)
class FilterTrack:
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


def track(
    data: VectorData,
    settings: KalmanSettings,
    window: int = 50,
    rule: NoiseRule = STEADY,
    engine: Engine = "compiled",
) -> FilterTrack:
    """Run the filter over the data, [Li2017] section 2.1, see `calib.numerics.kalman`."""
    run = filtered(
        data.difference_nT,
        data.observation(settings.offset_unit_nT),
        settings.start,
        np.eye(21) * settings.prior_variance,
        np.eye(21) * settings.state_variance,
        settings.noise_variance_nT2,
        rule,
        engine,
    )
    unit = settings.unit
    return FilterTrack(
        run.state * unit,
        run.variance * unit**2,
        run.covariance * np.outer(unit, unit),
        np.einsum("ni,nij,nj->n", run.innovation, run.inverse, run.innovation),
        run.noise,
        innovation_ratio(run.innovation, run.predicted, window),
    )


def innovation_ratio(innovation: Array, predicted_nT2: Array, window: int) -> Array:
    """ROR (n,) = tr(C_r) / tr(P_r), C_r the mean of r r^T over the last `window` innovations ([Li2017] eq. 11-15)."""
    total = np.cumsum((innovation**2).sum(axis=1))
    total[window:] -= total[:-window].copy()
    ratio = total / window / predicted_nT2
    ratio[: window - 1] = np.nan
    return np.asarray(ratio)


@dataclass(frozen=True)
class VectorFilter(Calibrator):
    """T_p, A and B by a Kalman filter of a constant state, sample by sample; a subclass says how R adapts.

    T_m - T = H x + v,  H = [I3 | T_3x9 | dT_3x9],  x = (T_p, A, B),  x_k = x_k-1 + w  ([Li2017] eq. 1 to 9, table 1)

    The claimed covariance is the filter's times `FilterTrack.variance_factor`. `engine`: the compiled filter, or
    filterpy's, which gives the same and takes ten times as long.
    """

    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector")
    min_samples: ClassVar[int] = 21
    eddy: ClassVar[bool] = True
    sequential: ClassVar[bool] = True
    settings: KalmanSettings = KalmanSettings()
    engine: Engine = "compiled"

    @abstractmethod
    def noise_rule(self) -> NoiseRule:
        """What gives the next sample's R."""

    @final
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        steps = track(VectorData.of(recording, reference), self.settings, rule=self.noise_rule(), engine=self.engine)
        return calibration(
            self.name,
            _status(steps, self.settings),
            steps.state[-1],
            steps.variance_factor * steps.covariance,
            {"nis_mean": float(steps.nis.mean()), "noise_variance_nT2": float(steps.noise_variance_nT2[-1])},
            _history(steps, self.settings),
        )


def _scaled(settings: KalmanSettings) -> Array:
    """Prior variance (21,) in nT^2, 1 and s^2."""
    return np.asarray(settings.prior_variance * settings.unit**2)


def _status(steps: FilterTrack, settings: KalmanSettings) -> Status:
    root = np.sqrt(_scaled(settings))
    values, vectors = np.linalg.eigh(steps.covariance / np.outer(root, root))
    if values[0] < 0 or steps.nis.min() < 0:
        return Status("not_converged", "the covariance is no longer positive definite: raise noise_variance_nT2")
    if values[-1] <= MAX_PRIOR_SHARE:
        return Status("ok")
    worst = NAMES[int(np.argmax(rounded_sizes(vectors[:, -1])))]
    return Status(
        "not_converged",
        f"the covariance has not come down: the start value still weighs {figure(values[-1], 2)} "
        f"(limit {MAX_PRIOR_SHARE:g}), most in {worst}; {_advice(worst, settings)}",
    )


def _advice(worst: str, settings: KalmanSettings) -> str:
    """What brings the covariance down: for an offset whose prior is too small another unit, else data or less drift."""
    if worst in OFFSET_NAMES and settings.offset_unit_nT < MICROTESLA_NT:
        return "use kalman_rescaled, in which T_p may move further"
    steady = "" if settings.state_variance == 0 else ", lower state_variance (0 for iron that stays)"
    return f"record longer, turn about more axes{steady}, or use vector_least_squares, which needs no start value"


def _history(steps: FilterTrack, settings: KalmanSettings) -> tuple[float, ...]:
    """Largest variance over its start, at no more than MAX_HISTORY samples, the last among them."""
    share = (steps.variance / _scaled(settings)).max(axis=1)
    picked = np.unique(np.linspace(0, len(share) - 1, min(MAX_HISTORY, len(share))).round().astype(int))
    return tuple(share[picked].tolist())
