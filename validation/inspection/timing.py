"""When the samples were taken: interval, jitter, gaps, and the true rate of every other column."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.dataset.columns import ACCEL, ATTITUDE, GYRO, POSITION, mag_names, numbers
from validation.inspection.finding import Finding, Level
from validation.inspection.log import Log
from validation.signals.faults import repeats, runs
from validation.signals.lattice import find_lattice
from validation.text import counted, duration, figure, frequency

Array = NDArray[np.float64]
SECTION = "time"
LONGEST_USUAL = 1.5
"""A gap is longer than this many usual intervals, the usual one being the larger of median and 95 % quantile."""
CONSTANT_JITTER = 1e-6
JITTER_NOTE, JITTER_WARNING = 0.05, 0.3
MOST_LISTED = 20
FEW_LENGTHS, RESOLUTION_DIGITS = 3, 9
"""Different intervals that an even clock in rounded stamps has; decimals of a second that a stamp can have."""
STALE_SHARE = 0.02
STALE_RATIO = 3.0
"""Rows repeat because the column is slower when next rows are equal this many times as often as rows further apart."""
KINK_SHARE = 0.97
"""Share of the second differences' sum that the kinks of an interpolated column hold."""
LEAST_KINK_ROWS = 6.0
"""Kinks nearer than this many rows run into each other."""


@dataclass(frozen=True)
class Gap:
    """A pause: `length_s` without a sample after the time `after_s`."""

    after_s: float
    length_s: float


def timing_findings(log: Log) -> list[Finding]:
    """Samples and duration, interval, jitter, gaps, time stamps out of order, and rates of the other columns."""
    stamps = log.columns["time_s"]
    time_s = np.unique(stamps[np.isfinite(stamps)])
    found = [_samples(stamps, time_s), _order(stamps)]
    if len(time_s) > 2:
        found[1:1] = [_interval(time_s), _jitter(time_s), _gaps(time_s)]
    return [*found, *_rates(log, time_s)]


def find_gaps(time_s: Array) -> list[Gap]:
    """Pauses in increasing times (n,)."""
    step = np.diff(time_s)
    if len(step) < 2:
        return []
    long = step > _longest_usual(step)
    return [Gap(float(t), float(s)) for t, s in zip(time_s[:-1][long], step[long], strict=True)]


def _longest_usual(step: Array) -> float:
    """The longest of intervals (n,) that is no gap."""
    return LONGEST_USUAL * float(max(np.median(step), np.quantile(step, 0.95)))


def _samples(stamps: Array, time_s: Array) -> Finding:
    length_s = float(np.ptp(time_s)) if len(time_s) else 0.0
    text = f"{counted(len(stamps), 'sample')} over {duration(length_s)}."
    few = len(time_s) < 100
    if few:
        text += " Too few for statements on noise, tones and slow changes."
    return Finding(SECTION, "samples", len(stamps), "", text, "note" if few else "ok")


def _interval(time_s: Array) -> Finding:
    interval_s = float(np.median(np.diff(time_s)))
    every = f"One sample in {duration(interval_s)}"
    text = f"{every}, {figure(1 / interval_s, 4)} Hz, in the median." if interval_s < 5 else f"{every} in the median."
    return Finding(SECTION, "interval", interval_s, "s", text)


def _jitter(time_s: Array) -> Finding:
    """Rms deviation of the intervals from their median, gaps left out."""
    step = np.diff(time_s)
    usual = float(np.median(step))
    kept = step[step <= _longest_usual(step)]
    jitter_s = float(np.sqrt(np.mean((kept - usual) ** 2)))
    share = jitter_s / usual
    if share < CONSTANT_JITTER:
        return Finding(SECTION, "jitter", jitter_s, "s", "The interval is constant.")
    text = f"The interval varies by {100 * share:.2g} % rms, from {duration(kept.min())} to {duration(kept.max())}"
    rounding_s = _rounding_s(time_s, kept)
    if rounding_s > 0 and jitter_s < rounding_s:
        text += f": no more than the time stamps' rounding to {duration(rounding_s)}"
        return Finding(SECTION, "jitter", jitter_s, "s", text + ".")
    level: Level = "warning" if share > JITTER_WARNING else "note" if share > JITTER_NOTE else "ok"
    if level == "warning":
        text += ": sampling is irregular, spectra and filters that count samples do not hold"
    return Finding(SECTION, "jitter", jitter_s, "s", text + ".", level)


def _rounding_s(time_s: Array, intervals: Array) -> float:
    """What the time stamps are rounded to, 0 where that does not show.

    An even clock in coarse stamps has a few different intervals alone, apart by the rounding.
    """
    lengths = np.unique(np.round(intervals, RESOLUTION_DIGITS))
    if 1 < len(lengths) <= FEW_LENGTHS:
        step_s = float(np.diff(lengths).min())
    else:
        lattice = find_lattice(time_s)
        step_s = lattice.step if lattice and not lattice.floating else 0.0
    return step_s if step_s < float(np.median(intervals)) / 2 else 0.0


def _gaps(time_s: Array) -> Finding:
    gaps = find_gaps(time_s)
    if not gaps:
        return Finding(SECTION, "gaps", [], "s", "No gap: samples follow each other without a pause.")
    longest = max(gaps, key=lambda gap: gap.length_s)
    total_s = sum(gap.length_s for gap in gaps)
    text = f"{counted(len(gaps), 'gap')}, {duration(total_s)} together; the longest, {duration(longest.length_s)}, "
    text += f"begins at {figure(longest.after_s, 6)} s."
    listed = sorted(sorted(gaps, key=lambda gap: -gap.length_s)[:MOST_LISTED], key=lambda gap: gap.after_s)
    value = [{"after_s": gap.after_s, "length_s": gap.length_s} for gap in listed]
    share = total_s / float(np.ptp(time_s))
    return Finding(SECTION, "gaps", value, "s", text, "warning" if share > 0.01 else "note")


def _order(stamps: Array) -> Finding:
    """Missing, repeated and decreasing time stamps."""
    missing = int(np.count_nonzero(~np.isfinite(stamps)))
    rows = np.flatnonzero(np.isfinite(stamps))
    step = np.diff(stamps[rows])
    counts = {"missing": missing, "repeated": int(np.sum(step == 0)), "decreasing": int(np.sum(step < 0))}
    listed = [f"{number:,} {name}" for name, number in counts.items() if number]
    if not listed:
        return Finding(SECTION, "order", counts, "", "Every time stamp is later than the one before.")
    text = f"Time stamps: {', '.join(listed)}"
    if (step <= 0).any():
        text += f"; the first in row {rows[int(np.argmax(step <= 0)) + 1] + 1}"
    text += ". Sort the rows, or cut the file where a new recording begins." if counts["decreasing"] else "."
    return Finding(SECTION, "order", counts, "", text, "warning")


def stale(values: Array) -> bool:
    """Whether rows of values (n, k) repeat because the column is slower, not because its value stands still."""
    if len(values) < 20:
        return False
    for first, rows in reversed(repeats(values).frozen):
        values = np.delete(values, np.s_[first + 1 : first + rows], axis=0)
    _, length = runs(values)
    near = 1.0 - len(length) / len(values)
    lag = max(2, int(np.ceil(3 * len(values) / len(length))))
    if near < STALE_SHARE or lag >= len(values) // 2:
        return False
    far = float(np.mean(np.all(values[lag:] == values[:-lag], axis=1)))
    return near > STALE_RATIO * far


def interpolation_rows(values: Array) -> float | None:
    """Mean distance in rows of the kinks of a column (n, k) that was interpolated linearly; None if it was not."""
    bend = np.abs(np.diff(values, 2, axis=0)).sum(axis=1)
    if len(bend) < 50 or not bend.max() > 0:
        return None
    strongest = np.sort(bend)[::-1]
    share = np.cumsum(strongest) / strongest.sum()
    enough = int(np.searchsorted(share, KINK_SHARE)) + 1
    if enough > 0.6 * len(bend):
        return None
    kink = np.flatnonzero(bend > 0.1 * np.quantile(bend, 1 - 0.5 * enough / len(bend)))
    start = kink[np.diff(np.r_[-10, kink]) > 1]
    if len(kink) < 10 or len(start) < 2:
        return None
    apart = float(len(bend) / len(start))
    regular = np.mean(np.abs(np.diff(start) / apart - 1) < 0.5)
    return apart if apart >= LEAST_KINK_ROWS and regular > 0.5 else None


def _rates(log: Log, time_s: Array) -> list[Finding]:
    """A finding for each column that is not new in every row, and one that names the others."""
    if len(time_s) < 20:
        return []
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


def _groups(log: Log) -> dict[str, Array]:
    """Columns (n, k) that belong together, by a readable name."""
    vectors = {"gyro": GYRO, "accelerometer": ACCEL, "attitude": ATTITUDE, "position": POSITION}
    vectors = {name: columns for name, columns in vectors.items() if log.vector(columns) is not None}
    sensors = {f"magnetometer {k or ''}".strip(): mag_names(k) for k in log.sensors}
    currents = tuple(f"current_{k}_A" for k in numbers("current", tuple(log.columns)))
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
    if rows < 0.9 * len(values):
        text = f"{head}a value in {100 * rows / len(values):.2g} % of the rows, {frequency(rows / length_s)}."
        return Finding(SECTION, key, rows / length_s, "Hz", text, "note")
    if stale(values[known]):
        rate = fresh / length_s
        text = f"{head}held, {frequency(rate)} (a new value in {100 * fresh / rows:.2g} % of the rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    apart = interpolation_rows(values[known]) if fresh > 0.8 * rows else None
    if apart is not None:
        rate = rows / length_s / apart
        text = f"{head}looks interpolated, from {frequency(rate)} (a kink every {apart:.3g} rows)."
        return Finding(SECTION, key, rate, "Hz", text, "note")
    return None if fresh > 0.9 * rows else _seldom(key, head, fresh, length_s)


def _seldom(key: str, head: str, fresh: int, length_s: float) -> Finding:
    rate = (fresh - 1) / length_s
    return Finding(SECTION, key, rate, "Hz", f"{head}{counted(fresh - 1, 'change')}, {frequency(rate)} in the mean.")
