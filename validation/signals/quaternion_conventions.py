"""Convention of a quaternion's four numbers, from the gyro and from directions that are fixed in the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.policy import POLICY

BASELINE_S = 0.1
"""Time over which rates are computed, one sample at least: shorter differences are mostly noise."""
FINE_LAG = 8
"""Rows on either side of the correlation's peak at which the lag is refined."""
CONVENTIONS: dict[str, tuple[tuple[int, ...], float]] = {
    "w, x, y, z, body to world": ((0, 1, 2, 3), 1.0),
    "w, x, y, z, world to body": ((0, 1, 2, 3), -1.0),
    "x, y, z, w, body to world": ((3, 0, 1, 2), 1.0),
    "x, y, z, w, world to body": ((3, 0, 1, 2), -1.0),
}
"""Columns of w, x, y, z, and the sign of the vector part."""
EXPECTED = next(iter(CONVENTIONS))


@dataclass(frozen=True)
class RateMatch:
    """Fit ``gyro = scale R omega + bias`` with omega the attitude's body rate; `share` of the variance is explained.

    angle_deg : angle of R, NaN where rates about a single axis do not determine R.
    lag_s : delay of the attitude.
    """

    share: float
    scale: float
    angle_deg: float
    lag_s: float = 0.0


def read_as(q: Array, convention: str) -> Array:
    """Return quaternions (n, 4) given in a convention, as w, x, y, z, body to world."""
    order, sign = CONVENTIONS[convention]
    return np.asarray(q[:, order] * [1.0, sign, sign, sign])


def match_rates(time_s: Array, q: Array, gyro: Array) -> RateMatch | None:
    """Compare a gyro (n, 3) with the rate of an attitude (n, 4), both over BASELINE_S; None where nothing turns.

    The lag of the attitude, at most 5 s, is the lag with the largest explained share.
    """
    pair = _rates(time_s, q, gyro)
    if pair is None:
        return None
    rate, turned, interval_s = pair
    middle = _coarse_lag(rate, turned, interval_s)
    lags = sorted({0, *range(middle - FINE_LAG, middle + FINE_LAG + 1)}, key=abs)
    matches = {lag: match for lag in lags if (match := _shifted(rate, turned, lag)) is not None}
    if not matches:
        return None
    best = max(matches, key=lambda lag: matches[lag].share)
    if 0 in matches and matches[best].share < matches[0].share + POLICY.lag_gain:
        best = 0
    return replace(matches[best], lag_s=best * interval_s)


def _rates(time_s: Array, q: Array, gyro: Array) -> tuple[Array, Array, float] | None:
    """Return rates (m, 3) of attitude and gyro over equal stretches, and the median interval in s."""
    sound = np.isfinite(q).all(axis=1) & np.isfinite(gyro).all(axis=1)
    time_s, q, gyro = time_s[sound], q[sound], gyro[sound]
    if len(time_s) < POLICY.least_rows:
        return None
    interval_s = float(np.median(np.diff(time_s)))
    step = max(1, round(BASELINE_S / interval_s))
    if len(time_s) < 2 * step + POLICY.least_rows:
        return None
    turned = np.zeros((len(gyro), 3))
    turned[1:] = np.cumsum(0.5 * (gyro[1:] + gyro[:-1]) * np.diff(time_s)[:, None], axis=0)
    length_s = time_s[step:] - time_s[:-step]
    usual = _usual(length_s)
    attitude = Rotation.from_quat(q, scalar_first=True)
    rate = (attitude[:-step].inv() * attitude[step:]).as_rotvec() / length_s[:, None]
    return rate[usual], ((turned[step:] - turned[:-step]) / length_s[:, None])[usual], interval_s


def _coarse_lag(rate: Array, gyro: Array, interval_s: float) -> int:
    """Return the lag in rows of the attitude's rate behind the gyro's, from the correlation of their norms."""
    a, b = (np.linalg.norm(values - values.mean(axis=0), axis=1) for values in (rate, gyro))
    most = min(round(POLICY.longest_lag_s / interval_s), len(a) // 4)
    from scipy.signal import correlate  # its import costs half a second, which logs without a gyro do not need

    correlation = correlate(a - a.mean(), b - b.mean(), method="fft")
    centre = len(a) - 1
    return int(np.argmax(correlation[centre - most : centre + most + 1])) - most


def _shifted(rate: Array, gyro: Array, lag: int) -> RateMatch | None:
    rows = len(rate) - abs(lag)
    return _similarity(rate[max(lag, 0) :][:rows], gyro[max(-lag, 0) :][:rows])


def _usual(length_s: Array) -> NDArray[np.bool_]:
    """Return whether stretches (n,) are free of gaps."""
    return np.asarray(length_s < POLICY.gap * np.median(length_s), np.bool_)


def _similarity(rate: Array, gyro: Array) -> RateMatch | None:
    """Fit the similarity from rates (n, 3) to the gyro's (n, 3): orthogonal Procrustes."""
    rate, gyro = rate - rate.mean(axis=0), gyro - gyro.mean(axis=0)
    power, total = float((rate**2).sum()), float((gyro**2).sum())
    if len(rate) < POLICY.least_directions or np.sqrt(power / len(rate)) < POLICY.least_rate_rad_s or total == 0:
        return None
    left, sizes, right = np.linalg.svd(gyro.T @ rate)
    sizes[2] *= np.sign(np.linalg.det(left @ right))
    rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    scale = float(sizes.sum()) / power
    share = 1.0 - float(((gyro - scale * rate @ rotation.T) ** 2).sum()) / total
    variance = np.linalg.eigvalsh(rate.T @ rate)
    angle_deg = float(np.degrees(Rotation.from_matrix(rotation).magnitude()))
    return RateMatch(share, scale, angle_deg if variance[1] > POLICY.second_axis * variance[2] else float("nan"))


def euler_deg(q: Array) -> Array:
    """Return yaw, pitch, roll (n, 3) in degrees of quaternions (n, 4), R_wb = Rz(yaw) Ry(pitch) Rx(roll)."""
    w, x, y, z = q.T
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return np.asarray(np.degrees(np.stack([yaw, pitch, roll], axis=1)))


def mean_direction(q: Array, body: Array) -> Array:
    """Return the mean (3,) of the directions of body vectors (n, 3) in the world; length 1 for a fixed direction."""
    finite = np.asarray(np.isfinite(np.column_stack([q, body])).all(axis=1), np.bool_)
    length = np.linalg.norm(np.where(finite[:, None], body, 0.0), axis=1)
    rows = np.arange(len(length))[length > 0]
    if len(rows) < POLICY.least_directions:
        return np.zeros(3)
    unit = body[rows] / length[rows, None]
    return np.asarray(Rotation.from_quat(q[rows], scalar_first=True).apply(unit).mean(axis=0))


def gyro_scale_from_field(time_s: Array, mag: Array, gyro: Array) -> tuple[float, float]:
    """Return scale k of the gyro and explained share, from ``dm/dt = -k omega x (m - b)`` with constant b.

    The derivative is taken over BASELINE_S. NaN where the gyro does not turn. Soft iron biases k.
    """
    sound = np.isfinite(gyro).all(axis=1)
    time_s, mag, gyro = time_s[sound], mag[sound], gyro[sound]
    if len(time_s) < POLICY.least_rows:
        return float("nan"), float("nan")
    half = max(1, round(0.5 * BASELINE_S / float(np.median(np.diff(time_s)))))
    if len(time_s) - 2 * half < POLICY.least_directions:
        return float("nan"), float("nan")
    length_s = time_s[2 * half :] - time_s[: -2 * half]
    usual = _usual(length_s)
    slope = ((mag[2 * half :] - mag[: -2 * half]) / length_s[:, None])[usual]
    total = np.concatenate([np.zeros((1, 3)), np.cumsum(gyro, axis=0)])
    rate = ((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))[usual]
    return _scale(slope, rate, mag[half:-half][usual])


def _scale(slope: Array, rate: Array, mag: Array) -> tuple[float, float]:
    """Fit k and k b in ``slope = -k rate x mag + rate x (k b)`` by least squares."""
    if not np.any(rate) or not np.any(slope):
        return float("nan"), float("nan")
    first = np.asarray(-np.cross(rate, mag)).reshape(-1, 1)
    x, y, z = rate.T
    zero = np.zeros_like(x)
    rest = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3)
    columns = np.concatenate([first, rest], axis=1)
    size = np.linalg.norm(columns, axis=0)
    size[size == 0] = 1.0
    fit = np.linalg.lstsq(columns / size, slope.ravel(), rcond=None)[0] / size
    share = 1.0 - float(((slope.ravel() - columns @ fit) ** 2).sum() / (slope**2).sum())
    return float(fit[0]), share
