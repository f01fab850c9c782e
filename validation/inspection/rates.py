"""Rate of new values of every column: in every row, held, interpolated, or rare."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from recordings.channels import current_name, motors_of
from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION, group_of, mag_names
from scenarios.arrays import Array
from validation.inspection.finding import Finding
from validation.inspection.log import RawLog
from validation.policy import POLICY
from validation.signals.faults import runs
from validation.signals.held import stale
from validation.text import counted, figure, frequency

SECTION = "time"


def rate_findings(log: RawLog) -> list[Finding]:
    """Return a finding for each slower column, and a list of columns that are new in every row.

    A channel, which no calibration needs, gives no note.
    """
    new, found = [], []
    for name, columns in _groups(log).items():
        finding = _rate(name, columns, log.columns["time_s"])
        if finding is None:
            new.append(name)
        else:
            channel = name in log.columns and group_of(name) == "channel"
            found.append(replace(finding, level="ok") if channel and finding.level == "note" else finding)
    if new:
        found.insert(0, Finding(SECTION, "full_rate", new, "", f"New in every row: {', '.join(new)}."))
    return found


def interpolation_rows(values: Array) -> float | None:
    """Return the mean distance in rows of the kinks of a linearly interpolated column (n, k), else None."""
    bend = np.abs(np.diff(values, 2, axis=0)).sum(axis=1)
    if len(bend) < POLICY.least_bends or not bend.max() > 0:
        return None
    strongest = np.sort(bend)[::-1]
    share = np.cumsum(strongest) / strongest.sum()
    enough = int(np.searchsorted(share, POLICY.kink_share)) + 1
    if enough > POLICY.most_kinks * len(bend):
        return None
    median = np.quantile(bend, 1 - 0.5 * enough / len(bend))
    kink = np.flatnonzero(bend > POLICY.kink_height * median)
    start = kink[np.diff(np.r_[-10, kink]) > 1]
    if len(kink) < POLICY.least_kinks or len(start) < 2:
        return None
    apart = float(len(bend) / len(start))
    regular = np.mean(np.abs(np.diff(start) / apart - 1) < POLICY.regular)
    return apart if apart >= POLICY.least_kink_rows and regular > POLICY.least_regular else None


def _groups(log: RawLog) -> dict[str, Array]:
    """Return columns (n, k) of each quantity by a readable name."""
    vectors = {"gyro": GYRO, "accelerometer": ACCEL, "attitude": ATTITUDE, "position": POSITION}
    vectors = {name: columns for name, columns in vectors.items() if log.vector(columns) is not None}
    sensors = {f"magnetometer {k or ''}".strip(): mag_names(k) for k in log.sensors}
    currents = tuple(current_name(motor) for motor in motors_of(log.columns))
    taken = {"time_s", *(name for names in (*sensors.values(), *vectors.values()) for name in names)}
    single = {name: (name,) for name in (*currents, *log.columns) if name not in taken}
    groups = {**sensors, **vectors, **single}
    return {name: vector for name, columns in groups.items() if (vector := log.vector(columns)) is not None}


def _rate(name: str, values: Array, stamps: Array) -> Finding | None:
    """Return a finding on the rate of new values, None for a new value in every row."""
    known = np.isfinite(values).all(axis=1) & np.isfinite(stamps)
    rows, length_s = int(known.sum()), float(np.ptp(stamps[np.isfinite(stamps)]))
    key = f"rate_{name.replace(' ', '_')}"
    if rows < 2 or length_s <= 0:
        return Finding(SECTION, key, 0.0, "Hz", f"{_head(name)}: no values.", "warning")
    fresh = len(runs(values[known])[0])
    head = f"{_head(name)}: "
    if fresh == 1:
        return Finding(SECTION, key, 0.0, "Hz", f"{head}one constant value.", "note")
    if rows < POLICY.sparse * len(values):
        text = f"{head}a value in {figure(100 * rows / len(values), 2)} % of the rows, {frequency(rows / length_s)}."
        return Finding(SECTION, key, rows / length_s, "Hz", text, "note")
    if stale(values[known]):
        rate = fresh / length_s
        text = f"{head}held, {frequency(rate)} (a new value in {figure(100 * fresh / rows, 2)} % of the rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    apart = interpolation_rows(values[known]) if fresh > POLICY.varying * rows else None
    if apart is not None:
        rate = rows / length_s / apart
        text = f"{head}apparently interpolated from {frequency(rate)} (a kink every {figure(apart)} rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    return None if fresh > POLICY.new * rows else _seldom(key, head, fresh, length_s)


def _seldom(key: str, head: str, fresh: int, length_s: float) -> Finding:
    rate = (fresh - 1) / length_s
    return Finding(SECTION, key, rate, "Hz", f"{head}{counted(fresh - 1, 'change')}, {frequency(rate)} on average.")


def _head(name: str) -> str:
    """Return what a sentence begins with; a name of a column, as current_1_A, keeps its first letter."""
    return name if "_" in name else name[0].upper() + name[1:]
