"""Steps of the offset: the field of the vehicle changes from one sample to the next and stays."""

from __future__ import annotations

import numpy as np

from calib.numerics.scans import largest_antisymmetric
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault
from validation.signals.intervals import gaps_after
from validation.text import counted, duration, figure

NORMAL_HALF = 0.6745
"""The median of |x| of a standard normal x."""
LARGE = 10_000
"""Samples that suffice for the median of an axis."""
NORMAL_90 = 1.645
"""The quantile of |x| of a standard normal x that nine tenths are below."""
SIDE = 4
"""Samples on either side of a step that are looked at."""


def offset_steps(recording: Recording) -> list[Fault]:
    """Return steps that neither a smooth course nor a turn explains; motor currents that are logged may explain any."""
    if recording.current_A is not None or len(recording) < POLICY.few_samples:
        return []
    mag_nT, found = recording.mag_nT, []
    for axis, column in enumerate(np.ascontiguousarray(mag_nT.T)):
        steps = [one for one in _steps(column, recording.time_s) if _two_offsets(mag_nT, one[0] + 1)]
        if steps:
            at, height = max(steps, key=lambda one: abs(one[1]))
            time = duration(float(recording.time_s[at + 1] - recording.time_s[0]))
            text = f"the offset of axis {AXES[axis]} steps by {figure(height)} nT {time} after the first row"
            text += f", and {counted(len(steps) - 1, 'more time')}" if len(steps) > 1 else ""
            text += ": something magnetic moved; calibrate the parts alone"
            found.append(Fault("step", text, np.zeros(len(column), np.bool_), "none", doubtful=True))
    return found


def _two_offsets(mag_nT: Array, after: int) -> bool:
    """Return whether the field (n, 3) fits two ellipsoids of one shape much better than one: a step, not a turn."""
    if min(after, len(mag_nT) - after) < POLICY.step_rows:
        return False
    x, y, z = ((mag_nT - mag_nT.mean(axis=0)) / mag_nT.std()).T
    one = np.column_stack([x * x, y * y, z * z, x * y, x * z, y * z, x, y, z])
    late = np.arange(len(mag_nT)) >= after
    two = np.column_stack([one, late, *(late * axis for axis in (x, y, z))])
    return bool(_scatter(one) > POLICY.step_gain * _scatter(two))


def _scatter(columns: Array) -> float:
    """Return the rms residual of columns @ c = 1."""
    rest = columns @ np.linalg.lstsq(columns, np.ones(len(columns)), rcond=None)[0] - 1.0
    return float(np.sqrt(np.mean(rest**2)))


def _functional() -> Array:
    """Return weights (2 SIDE,) of the step in a least-squares fit of a cubic and a step after the middle."""
    t = np.arange(2 * SIDE) - SIDE + 0.5
    columns = np.column_stack([np.ones_like(t), t, t**2, t**3, t > 0])
    return np.asarray(np.linalg.pinv(columns)[-1])


def _fitted(column: Array) -> Array:
    """Return the height of a step (n - 2 SIDE + 1,) after each sample from SIDE - 1 on."""
    return np.correlate(column, _functional(), "valid")


def _ordinary(column: Array) -> bool:
    """Return whether no step of an axis (n,) is larger than noise gives, by the overall noise."""
    part = np.lib.stride_tricks.sliding_window_view(column, 2 * SIDE)[:: max(1, len(column) // LARGE)]
    usual = float(np.median(np.abs(part @ _functional()))) / NORMAL_HALF
    largest = largest_antisymmetric(column, -_functional()[SIDE - 1 :: -1])
    return bool(largest <= POLICY.step_sigma * usual)


def _steps(column: Array, time_s: Array) -> list[tuple[int, float]]:
    """Return the samples before a step, and the heights: what is left after the step is taken out is ordinary."""
    if _ordinary(column):
        return []
    fitted, gaps = _fitted(column), gaps_after(time_s)
    size = np.abs(fitted)
    limit = POLICY.step_sigma * _local_scale(size)
    found: list[tuple[int, float]] = []
    near_gap = np.zeros(len(fitted), np.bool_)
    near_gap[np.clip(gaps[:, None] - np.arange(2 * SIDE - 1), 0, len(fitted) - 1).ravel()] = True
    candidates = np.flatnonzero((np.abs(fitted) > limit) & ~near_gap)
    for k in candidates[np.argsort(-np.abs(fitted[candidates]))][: POLICY.most_steps]:
        if _clean_without(column, int(k), float(fitted[k])):
            found.append((int(k) + SIDE - 1, float(fitted[k])))
    return found


def _clean_without(column: Array, k: int, height: float) -> bool:
    """Return whether an axis (n,) is ordinary around the fit k once the step of that height is taken out."""
    around = slice(max(0, k - 2 * SIDE), k + 4 * SIDE)
    rest = column[around].copy()
    rest[k + SIDE - around.start :] -= height
    left = np.abs(_fitted(rest))
    return bool(len(left) and left.max() < POLICY.step_left * abs(height))


def _local_scale(size: Array) -> Array:
    """Return a robust standard deviation (n,) of sizes (n,): overall, or of the roughest tenth nearby."""
    width = min(len(size), 2 * POLICY.few_samples)
    blocks = np.array_split(size, max(1, len(size) // width))
    local = np.repeat([np.quantile(block, 0.9) / NORMAL_90 for block in blocks], [len(block) for block in blocks])
    return np.asarray(np.maximum(local, np.median(size) / NORMAL_HALF))
