"""Turns of the magnetometer's axes that a gyro allows: the field must turn as the gyro measures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scenarios.arrays import Array
from validation.axes.evidence import AxisCondition, MapEvidence, evidence
from validation.axes.maps import TURNS
from validation.axes.policy import AXES
from validation.axes.rows import AxisRows, piece_moments, rows_of
from validation.policy import POLICY

LEVI_CIVITA = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    LEVI_CIVITA[_i, _j, _k], LEVI_CIVITA[_i, _k, _j] = 1.0, -1.0
MAP, CENTRE, BIAS, DRIFT = slice(0, 9), slice(9, 12), slice(12, 15), slice(15, 18)
"""Parameters theta: map N, k N c, bias of the gyro, and its product with the centre c."""
CHANGE, PRODUCT, ANGLE, SUM, LENGTH = slice(0, 3), slice(3, 12), slice(12, 15), slice(15, 18), 18
"""Functions F of a window: change of m, integrals of w_i m_j, w and m, and the window's length."""


@dataclass(frozen=True)
class GyroEvidence:
    """Evidence of a gyro; `gain` (24,) true rate over measured rate for each turn; `lag_s` delay of the gyro.

    reversed : whether the gyro has the wrong sense for every turn and the evidence holds for the opposite sense.
    """

    evidence: MapEvidence
    gain: Array
    lag_s: float
    reversed: bool = False


@dataclass(frozen=True)
class _Windows:
    """Second moments (pieces, 19, 19) of the functions, the field's squared change, and independent windows."""

    moments: Array
    signal: float
    samples: float


def gyro_evidence(time_s: Array, mag_nT: Array, gyro: Array) -> GyroEvidence | None:
    """Return which turns P satisfy ``d(P m)/dt = -k w x (P m - c)``; None for too few rows or a gyro at rest.

    time_s (n,), mag_nT (n, 3) measured, gyro (n, 3) in any unit. Soft iron, scale factors and small angles of mounting
    are nuisance parameters: N = P + D; so are the gyro's gain k > 0 and a constant bias.
    """
    rows = rows_of(time_s, mag_nT, gyro, averaged=True)
    if rows is None:
        return None
    rate = float(np.sqrt(np.mean(rows.other**2)))
    if not rate > 0:
        return None
    rows = replace(rows, other=rows.other / rate)
    found = _best_lag(rows, rows.step)
    if found is None:
        return None
    return replace(found, gain=found.gain / rate)


def _best_lag(rows: AxisRows, step: int) -> GyroEvidence | None:
    """Return the evidence at the delay of the gyro that explains most."""
    tried: dict[float, GyroEvidence] = {}

    def attempt(lags_s: tuple[float, ...]) -> None:
        for lag_s in lags_s:
            if (found := _at_lag(rows, step, lag_s)) is not None:
                tried[lag_s] = found

    attempt(AXES.lags_s[:1])
    if not tried:
        return None
    if tried[0.0].evidence.share < 1 - AXES.least_error:
        attempt(AXES.lags_s[1:])
        best_s = _best(tried)
        attempt(tuple(best_s + lag_s for lag_s in AXES.finer_lags_s))
    return tried[_best(tried)]


def _best(tried: dict[float, GyroEvidence]) -> float:
    return max(tried, key=lambda lag_s: tried[lag_s].evidence.share)


def _at_lag(rows: AxisRows, step: int, lag_s: float) -> GyroEvidence | None:
    windows = _windows(rows, step, lag_s)
    if windows is None:
        return None
    gain = _gains(windows)
    found = _evidence(windows, np.maximum(gain, 0.0), lag_s)
    if found.evidence.share > AXES.least_share:
        return found
    opposite = _evidence(windows, np.minimum(gain, 0.0), lag_s)
    return replace(opposite, reversed=True) if opposite.evidence.share > AXES.least_share else found


def _evidence(windows: _Windows, gain: Array, lag_s: float) -> GyroEvidence:
    prior_std = np.full(18, np.inf)
    prior_std[MAP] = AXES.distortion
    prior_std[BIAS] = prior_std[DRIFT] = AXES.bias_share
    found = evidence(AxisCondition(windows.moments, _design(gain), windows.signal, windows.samples, prior_std))
    return GyroEvidence(found, gain, lag_s)


def _windows(rows: AxisRows, step: int, lag_s: float) -> _Windows | None:
    """Return the moments of overlapping windows of `step` rows with a gyro that is late by `lag_s`."""
    total = _integrals(rows, lag_s)
    length_s = rows.time_s[step:] - rows.time_s[:-step]
    usual = length_s < POLICY.gap * np.median(length_s)
    changes = rows.mag[step:] - rows.mag[:-step]
    functions = np.column_stack([changes, total[step:] - total[:-step], length_s])[usual]
    if len(functions) < AXES.least_rows:
        return None
    weight = 1.0 / step
    moments = weight * piece_moments(functions, rows.piece[:-step][usual])
    signal = float(np.trace(moments.sum(axis=0)[CHANGE, CHANGE]))
    return _Windows(moments, signal, weight * len(functions)) if signal > 0 else None


def _integrals(rows: AxisRows, lag_s: float) -> Array:
    """Return the integrals (n, 15) of w_i m_j, w and m from the first row on, by the trapezoidal rule."""
    rate = rows.other
    if lag_s:
        rate = np.stack([np.interp(rows.time_s + lag_s, rows.time_s, column) for column in rate.T], axis=1)
    products = (rate[:, :, None] * rows.mag[:, None, :]).reshape(-1, 9)
    integrand = np.concatenate([products, rate, rows.mag], axis=1)
    total = np.zeros_like(integrand)
    total[1:] = np.cumsum(0.5 * (integrand[1:] + integrand[:-1]) * np.diff(rows.time_s)[:, None], axis=0)
    return total


def _gains(windows: _Windows) -> Array:
    """Return k (24,) by least squares of ``P dm = -k int w x P m + int w x c' - b x int P m``, N = P."""
    fixed, per_gain = _constant_design(), _gain_design()
    by_map = _bias_design()
    start = TURNS.reshape(-1, 9)
    change = np.einsum("cfp,hp->hcf", fixed[..., MAP], start)
    turned = np.einsum("cfp,hp->hcf", per_gain[..., MAP], start)
    rest = np.broadcast_to(fixed[..., 9:], (len(TURNS), 3, 19, 9)) + by_map[..., 9:]
    columns = np.concatenate([turned[..., None], rest], axis=-1)
    total = windows.moments.sum(axis=0)
    weighed = np.einsum("hcfp,fg->hcpg", columns, total)
    normal = np.einsum("hcpg,hcgq->hpq", weighed, columns)
    right = -np.einsum("hcpg,hcg->hp", weighed, change)
    count = windows.samples * 3
    variance = AXES.least_error * windows.signal / count
    ridge = np.zeros(10)
    ridge[4:] = variance / AXES.bias_share**2
    size = np.trace(normal, axis1=1, axis2=2)
    damped = normal + np.diag(ridge) + 1e-12 * size[:, None, None] * np.eye(10)
    return np.asarray(np.linalg.solve(damped, right[..., None])[:, 0, 0])


def _design(gain: Array) -> Array:
    """Return B (24, 3, 19, 18) of the condition ``N dm + k int w x N m - int w x c' + b x int P m + d T = 0``."""
    return _constant_design() + gain[:, None, None, None] * _gain_design() + _bias_design()


def _constant_design() -> Array:
    """Return the part (3, 19, 18) of B that depends on neither gain nor map."""
    design = np.zeros((3, 19, 18))
    for i in range(3):
        design[i, CHANGE, 3 * i : 3 * i + 3] = np.eye(3)
        design[i, ANGLE, CENTRE] = LEVI_CIVITA[i]
        design[i, LENGTH, DRIFT.start + i] = 1.0
    return design


def _gain_design() -> Array:
    """Return the part (3, 19, 18) of B that the gain multiplies: integrals of w x N m."""
    design = np.zeros((3, 19, 18))
    for i, a, b in np.argwhere(LEVI_CIVITA):
        for j in range(3):
            design[i, PRODUCT.start + 3 * a + j, 3 * b + j] = LEVI_CIVITA[i, a, b]
    return design


def _bias_design() -> Array:
    """Return the part (24, 3, 19, 18) of B of the gyro's bias: b x P m."""
    design = np.zeros((len(TURNS), 3, 19, 18))
    design[:, :, SUM, BIAS] = np.einsum("iab,hbj->hija", LEVI_CIVITA, TURNS)
    return design
