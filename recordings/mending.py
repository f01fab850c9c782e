"""Rows and times of a log mended where the rest is enough: each change is counted and told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.columns import ACCEL, GYRO, mag_names, numbers
from recordings.importer import RawColumns
from scenarios.arrays import Array

Rows = NDArray[np.intp]
SPARSE = 0.5
"""Share of rows without a field above which the magnetometer is slower than the log, not interrupted."""
WRAPS_S = {
    "32-bit microseconds": 2**32 / 1e6,
    "32-bit milliseconds": 2**32 / 1e3,
    "16-bit milliseconds": 2**16 / 1e3,
    "31-bit microseconds": 2**31 / 1e6,
    "24-bit microseconds": 2**24 / 1e6,
}
"""The periods of the counters that a clock is read from."""
WRAP_STEPS = 20.0
"""Usual steps within which the next sample follows a counter's wrap."""
LATE_ROWS = 5
"""Rows out of order within which a time that goes back is late, not a clock that was set back."""
LEAST_ROWS = 2


def mended(raw: RawColumns) -> RawColumns:
    """Return the columns without rows that lack a field, with times that increase; a note for each kind of change.

    Columns without such faults are returned as they are. Rows that cannot be mended are left for `checks`.
    """
    if raw.strict:
        return raw
    known = _known(raw)
    if known.any() and not known.all():
        raw = _without_field(raw, known)
    if not raw.origin.timed:
        return raw
    finite = np.isfinite(raw.named["time_s"])
    if not finite.any():
        return raw
    if not finite.all():
        count = int(np.count_nonzero(~finite))
        raw = _told(_taken(raw, np.flatnonzero(finite)), f"{count} of {len(finite)} rows have no time and were skipped")
    if len(raw.named["time_s"]) < LEAST_ROWS or (np.diff(raw.named["time_s"]) > 0).all():
        return raw
    for step in (_reversed, _unwrapped, _without_copies, _continued, _sorted, _spread):
        raw = step(raw)
    return raw


def _known(raw: RawColumns) -> NDArray[np.bool_]:
    """Return the rows (n,) in which every magnetometer has a field."""
    sensors = numbers("mag", tuple(raw.named)) or (None,)
    columns = [raw.named[name] for sensor in sensors for name in mag_names(sensor)]
    return np.asarray(np.logical_and.reduce([np.isfinite(column) for column in columns]))


def _without_field(raw: RawColumns, known: NDArray[np.bool_]) -> RawColumns:
    """Return the rows with a field; of a faster log the gyro and the accelerometer as means around these rows."""
    rows, total = np.flatnonzero(known), len(known)
    found = _taken(raw, rows)
    if len(rows) > SPARSE * total:
        count = total - len(rows)
        return _told(found, f"{count} of {total} rows have no field (empty or not a number) and were skipped")
    means = {name: _means(raw.named[name], rows) for name in (*GYRO, *ACCEL) if name in raw.named}
    text = f"the magnetometer has a value in {len(rows)} of {total} rows: these are the samples"
    text += "; gyro and accelerometer are means around them" if means else ""
    return _told(replace(found, named=found.named | means), text)


def _means(values: Array, rows: Rows) -> Array:
    """Return the means (m,) of finite values (n,) between the middles to the neighbouring rows (m,)."""
    middle = (rows[1:] + rows[:-1]) // 2 + 1
    edges = np.r_[max(0, 2 * rows[0] - middle[0] + 1), middle] if len(middle) else np.array([0])
    finite = np.isfinite(values)
    total = np.add.reduceat(np.where(finite, values, 0.0), edges)
    with np.errstate(invalid="ignore"):
        return np.asarray(total / np.add.reduceat(finite.astype(float), edges))


def _reversed(raw: RawColumns) -> RawColumns:
    """Return the rows from the last to the first where their times only fall, as in a list with the newest on top."""
    step = np.diff(raw.named["time_s"])
    if (step > 0).any() or not (step < 0).any():
        return raw
    return _told(_taken(raw, np.arange(len(step), -1, -1)), "the times fall from row to row: the rows were reversed")


def _unwrapped(raw: RawColumns) -> RawColumns:
    """Return the columns with a counter's wraps added to the times."""
    time_s, back, usual_s = _steps(raw)
    for name, period_s in WRAPS_S.items():
        wraps = [row for row in back if 0 < time_s[row] - time_s[row - 1] + period_s <= WRAP_STEPS * usual_s]
        if wraps:
            text = f"the clock wraps {_times(len(wraps))}, as {name} do every {period_s:.6g} s: continued"
            return _told(_with_time(raw, time_s + period_s * _counted(wraps, len(time_s))), text)
    return raw


def _without_copies(raw: RawColumns) -> RawColumns:
    """Return the columns without rows that equal the previous row in all numbers."""
    time_s = raw.named["time_s"]
    same = np.diff(time_s) == 0
    for values in raw.named.values():
        if not same.any():
            return raw
        if values.dtype.kind == "f":
            same &= (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    if not same.any():
        return raw
    kept = np.flatnonzero(np.r_[True, ~same])
    return _told(_taken(raw, kept), f"{np.count_nonzero(same)} rows are copies of the previous row and were removed")


def _continued(raw: RawColumns) -> RawColumns:
    """Return the columns with the times after a clock that was set back continued by the usual step."""
    time_s, back, usual_s = _steps(raw)
    ahead = np.maximum.accumulate(time_s)
    resets = [row for row in back if row + LATE_ROWS < len(time_s) and time_s[row + LATE_ROWS] <= ahead[row - 1]]
    resets = [row for k, row in enumerate(resets) if not k or row - resets[k - 1] > LATE_ROWS]
    if not resets:
        return raw
    jumps_s = [float(time_s[row - 1] - time_s[row]) for row in resets]
    later = np.zeros(len(time_s))
    for row, jump_s in zip(resets, jumps_s, strict=True):
        later[row:] += jump_s + usual_s
    text = f"the clock was set back {_times(len(resets))}, by {max(jumps_s):.6g} s"
    text += " at most" if len(resets) > 1 else ""
    return _told(_with_time(raw, time_s + later), f"{text} in row {resets[0] + 1}: continued")


def _sorted(raw: RawColumns) -> RawColumns:
    """Return the rows in order of time."""
    time_s, back, _ = _steps(raw)
    if not len(back):
        return raw
    order = np.argsort(time_s, kind="stable")
    text = f"{_rows(len(back))} out of order of time, the first in row {back[0] + 1}: sorted"
    return _told(_taken(raw, order), text)


def _spread(raw: RawColumns) -> RawColumns:
    """Return the columns with repeated stamps spread evenly until the next stamp: the clock is coarser than the rate.

    t = s_k + j (s_k+1 - s_k) / n_k for sample j of the n_k with stamp s_k; a pause after a stamp is left out of the
    step, and the first stamp's samples end where the second stamp begins.
    """
    time_s = raw.named["time_s"]
    first = np.flatnonzero(np.r_[True, np.diff(time_s) > 0])
    if len(first) in (1, len(time_s)):
        return raw
    stamps, counts = time_s[first], np.diff(np.r_[first, len(time_s)])
    usual_s, usual = float(np.median(np.diff(stamps))), max(1.0, float(np.median(counts)))
    tick_s = np.minimum(np.r_[np.diff(stamps), usual_s], usual_s)
    step_s = tick_s / np.maximum(counts, np.r_[usual, np.zeros(len(counts) - 2), usual])
    within = np.arange(len(time_s)) - np.repeat(first, counts)
    spread_s = np.repeat(stamps, counts) + within * np.repeat(step_s, counts)
    if (counts[0] < usual and counts[0] > 1) or usual > 1:
        spread_s[: counts[0]] = stamps[1] - step_s[0] * np.arange(counts[0], 0, -1)
    repeated = len(time_s) - len(first)
    return _told(_with_time(raw, spread_s), f"{repeated} rows repeat a time: spread evenly between the stamps")


def _steps(raw: RawColumns) -> tuple[Array, Rows, float]:
    """Return the times, the rows at which they go back, and the median of the steps ahead."""
    time_s = raw.named["time_s"]
    step_s = np.diff(time_s)
    ahead = step_s[step_s > 0]
    return time_s, np.flatnonzero(step_s < 0) + 1, float(np.median(ahead)) if len(ahead) else 0.0


def _counted(rows: Sequence[int], total: int) -> Array:
    """Return how many of the rows lie at or before each of all rows."""
    marks = np.zeros(total)
    marks[list(rows)] = 1.0
    return np.cumsum(marks)


def _taken(raw: RawColumns, rows: Rows) -> RawColumns:
    return replace(raw, named={name: values[rows] for name, values in raw.named.items()})


def _with_time(raw: RawColumns, time_s: Array) -> RawColumns:
    named: dict[str, NDArray[Any]] = {**raw.named, "time_s": time_s}
    return replace(raw, named=named)


def _told(raw: RawColumns, text: str) -> RawColumns:
    return replace(raw, origin=replace(raw.origin, notes=(*raw.origin.notes, text)))


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _rows(count: int) -> str:
    return "1 row is" if count == 1 else f"{count} rows are"
