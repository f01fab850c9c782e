"""How often every column beside the time has a new value: in every row, held, interpolated, seldom."""

from __future__ import annotations

import numpy as np

from recordings.channels import current_name, motors_among
from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION, mag_names
from scenarios.arrays import Array
from validation.inspection.finding import Finding
from validation.inspection.log import RawLog
from validation.signals.faults import repeats, runs
from validation.text import counted, frequency

SECTION = "time"
LEAST_ROWS = 20
"""Rows below which nothing is said of a column's rate."""
STALE_SHARE = 0.02
"""Share of rows that equal the one before, below which the column is new in every row."""
STALE_RATIO = 3.0
"""Rows repeat because the column is slower when next rows are equal this many times as often as rows further apart."""
STALE_LAG = 3
"""Usual lengths of a run of equal rows by which those further apart are apart."""
LEAST_BENDS = 50
"""Rows below which interpolation is not looked for."""
KINK_SHARE = 0.97
"""Share of the second differences' sum that the kinks of an interpolated column hold."""
MOST_KINKS = 0.6
"""Share of the rows that have a kink, beyond which a column is just rough."""
KINK_HEIGHT = 0.1
"""A kink bends at least so much of what the median one does."""
LEAST_KINKS = 10
"""Kinks by which interpolation is told."""
LEAST_KINK_ROWS = 6.0
"""Kinks nearer than this many rows run into each other."""
REGULAR, LEAST_REGULAR = 0.5, 0.5
"""Part of the mean distance by which that of regular kinks may differ from it, and the least share of regular ones."""
SPARSE = 0.9
"""Share of the rows with a value, below which a column is sparse."""
VARYING = 0.8
"""Share of rows with a new value, from which on a column may be interpolated."""
NEW = 0.9
"""Share of rows with a new value, from which on it is new in every row."""


def rate_findings(log: RawLog) -> list[Finding]:
    """A finding for each column that is not new in every row, and one that names the others."""
    new, found = [], []
    for name, columns in _groups(log).items():
        finding = _rate(name, columns, log.columns["time_s"])
        if finding is None:
            new.append(name)
        else:
            found.append(finding)
    if new:
        found.insert(0, Finding(SECTION, "full_rate", new, "", f"New in every row: {', '.join(new)}."))
    return found


def stale(values: Array) -> bool:
    """Whether rows of values (n, k) repeat because the column is slower, not because its value stands still."""
    if len(values) < LEAST_ROWS:
        return False
    for first, rows in reversed(repeats(values).frozen):
        values = np.delete(values, np.s_[first + 1 : first + rows], axis=0)
    _, length = runs(values)
    near = 1.0 - len(length) / len(values)
    lag = max(2, int(np.ceil(STALE_LAG * len(values) / len(length))))
    if near < STALE_SHARE or lag >= len(values) // 2:
        return False
    far = float(np.mean(np.all(values[lag:] == values[:-lag], axis=1)))
    return near > STALE_RATIO * far


def interpolation_rows(values: Array) -> float | None:
    """Mean distance in rows of the kinks of a column (n, k) that was interpolated linearly; None if it was not."""
    bend = np.abs(np.diff(values, 2, axis=0)).sum(axis=1)
    if len(bend) < LEAST_BENDS or not bend.max() > 0:
        return None
    strongest = np.sort(bend)[::-1]
    share = np.cumsum(strongest) / strongest.sum()
    enough = int(np.searchsorted(share, KINK_SHARE)) + 1
    if enough > MOST_KINKS * len(bend):
        return None
    median = np.quantile(bend, 1 - 0.5 * enough / len(bend))
    kink = np.flatnonzero(bend > KINK_HEIGHT * median)
    start = kink[np.diff(np.r_[-10, kink]) > 1]
    if len(kink) < LEAST_KINKS or len(start) < 2:
        return None
    apart = float(len(bend) / len(start))
    regular = np.mean(np.abs(np.diff(start) / apart - 1) < REGULAR)
    return apart if apart >= LEAST_KINK_ROWS and regular > LEAST_REGULAR else None


def _groups(log: RawLog) -> dict[str, Array]:
    """Columns (n, k) that belong together, by a readable name."""
    vectors = {"gyro": GYRO, "accelerometer": ACCEL, "attitude": ATTITUDE, "position": POSITION}
    vectors = {name: columns for name, columns in vectors.items() if log.vector(columns) is not None}
    sensors = {f"magnetometer {k or ''}".strip(): mag_names(k) for k in log.sensors}
    currents = tuple(current_name(motor) for motor in motors_among(log.columns))
    taken = {"time_s", *(name for names in (*sensors.values(), *vectors.values()) for name in names)}
    single = {name: (name,) for name in (*currents, *log.columns) if name not in taken}
    groups = {**sensors, **vectors, **single}
    return {name: vector for name, columns in groups.items() if (vector := log.vector(columns)) is not None}


def _rate(name: str, values: Array, stamps: Array) -> Finding | None:
    """How often a column has a new value, None where in every row."""
    known = np.isfinite(values).all(axis=1) & np.isfinite(stamps)
    rows, length_s = int(known.sum()), float(np.ptp(stamps[np.isfinite(stamps)]))
    key = f"rate_{name.replace(' ', '_')}"
    if rows < 2 or length_s <= 0:
        return Finding(SECTION, key, 0.0, "Hz", f"{name[0].upper()}{name[1:]}: no values.", "warning")
    fresh = len(runs(values[known])[0])
    head = f"{name[0].upper()}{name[1:]}: "
    if fresh == 1:
        return Finding(SECTION, key, 0.0, "Hz", f"{head}one constant value.", "note")
    if rows < SPARSE * len(values):
        text = f"{head}a value in {100 * rows / len(values):.2g} % of the rows, {frequency(rows / length_s)}."
        return Finding(SECTION, key, rows / length_s, "Hz", text, "note")
    if stale(values[known]):
        rate = fresh / length_s
        text = f"{head}held, {frequency(rate)} (a new value in {100 * fresh / rows:.2g} % of the rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    apart = interpolation_rows(values[known]) if fresh > VARYING * rows else None
    if apart is not None:
        rate = rows / length_s / apart
        text = f"{head}looks interpolated, from {frequency(rate)} (a kink every {apart:.3g} rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    return None if fresh > NEW * rows else _seldom(key, head, fresh, length_s)


def _seldom(key: str, head: str, fresh: int, length_s: float) -> Finding:
    rate = (fresh - 1) / length_s
    return Finding(SECTION, key, rate, "Hz", f"{head}{counted(fresh - 1, 'change')}, {frequency(rate)} in the mean.")
