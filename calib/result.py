"""What a calibrator returns: the estimate, how sure it is, and whether it can be used."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from calib.rates import body_rate, smoothed_derivative
from sim.dataset import Recording

Array = NDArray[np.float64]
Kind = Literal["ok", "not_converged", "unobservable", "not_applicable"]
OFFSET_NAMES = ("offset_x_nT", "offset_y_nT", "offset_z_nT")
DERIVATIVE_ROUNDS = 3
"""Rounds of the fixed point that finds h and dh/dt when no body rate is known."""


@dataclass(frozen=True)
class Status:
    """How a fit ended; a reason, and what to do about it, for everything but "ok"."""

    kind: Kind
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A fitted measurement model and its inverse.

    m = S h + b + B dh/dt,  matrix = S^-1;  static case: h = matrix (m - b)

    m measured and h true field in the body frame, nT; `offset_nT` b (3,), `matrix` (3, 3), `eddy_s` B (3, 3) or None.
    `parameters` holds named values; `covariance` (p, p) belongs to the p of them listed in `covariance_names`.
    `history` is the method's own measure of convergence, a value a round. A fit without an estimate leaves b = 0 and
    matrix = I (the raw measurement), and `status` says why.
    """

    name: str
    status: Status
    offset_nT: Array = field(default_factory=lambda: np.zeros(3))
    matrix: Array = field(default_factory=lambda: np.eye(3))
    eddy_s: Array | None = None
    parameters: dict[str, float] = field(default_factory=dict)
    covariance: Array | None = None
    covariance_names: tuple[str, ...] = ()
    history: tuple[float, ...] = ()
    wall_s: float = 0.0

    @property
    def offset_covariance_nT2(self) -> Array | None:
        """Claimed covariance (3, 3) of the offset, nT^2; None where the method gives none."""
        if self.covariance is None or not set(OFFSET_NAMES) <= set(self.covariance_names):
            return None
        rows = [self.covariance_names.index(name) for name in OFFSET_NAMES]
        return self.covariance[np.ix_(rows, rows)]

    def apply(self, recording: Recording) -> Array:
        """Calibrated field (n, 3), nT, body frame.

        Without eddy term h = matrix (m - b). With it dh/dt = -omega x h, so (S - B [omega]x) h = m - b is solved sample
        by sample, omega being the gyro's or else the attitude's derivative; without either dh/dt is the smoothed
        derivative of the field itself, found together with it by a few fixed-point rounds.
        """
        centred = recording.mag_nT - self.offset_nT
        if self.eddy_s is None:
            return np.asarray(centred @ self.matrix.T)
        rate = body_rate(recording)
        if rate is None:
            return self._apply_by_derivative(centred, recording.time_s)
        system = np.linalg.inv(self.matrix) - self.eddy_s @ _cross_matrices(rate)
        return np.asarray(np.linalg.solve(system, centred[:, :, None])[:, :, 0])

    def _apply_by_derivative(self, centred: Array, time_s: Array) -> Array:
        assert self.eddy_s is not None
        h = centred @ self.matrix.T
        for _ in range(DERIVATIVE_ROUNDS):
            h = (centred - smoothed_derivative(h, time_s) @ self.eddy_s.T) @ self.matrix.T
        return np.asarray(h)


def _cross_matrices(v: Array) -> Array:
    """[v]x (n, 3, 3), so that [v]x a = v x a."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return out - out.transpose(0, 2, 1)
