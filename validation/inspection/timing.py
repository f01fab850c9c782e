"""Time stamps: interval, jitter, gaps, order."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from recordings.units import UNITS
from scenarios.arrays import Array
from validation.inspection.finding import Finding, Level
from validation.inspection.log import RawLog, series_of
from validation.inspection.rates import SECTION, rate_findings
from validation.inspection.sensor_data import attitude_of
from validation.policy import POLICY
from validation.signals.lattice import find_lattice
from validation.signals.time_units import finer_unit
from validation.text import counted, duration, figure

SLOW_S = 5.0
"""Interval from which on no rate in Hz is written."""
MOST_LISTED = 20
"""Gaps that are listed."""
RESOLUTION_DIGITS = 9
"""Decimals of a second that a time stamp can have."""


@dataclass(frozen=True)
class Gap:
    """Pause of `length_s` without samples after the time `after_s`."""

    after_s: float
    length_s: float


def timing_findings(log: RawLog) -> list[Finding]:
    """Return findings on samples, duration, interval, jitter, gaps, order, and rates of the other columns."""
    stamps = log.columns["time_s"]
    time_s = np.unique(stamps[np.isfinite(stamps)])
    found = [_samples(stamps, time_s), _order(log.as_found["time_s"])]
    if len(time_s) > 2:
        found[1:1] = [_interval(time_s), _jitter(time_s), _gaps(time_s)]
    return [*found, *rate_findings(log)] if len(time_s) >= POLICY.least_rate_rows else found


def in_seconds(log: RawLog) -> tuple[RawLog, list[Finding]]:
    """Return the log with time stamps in seconds where a gyro confirms a finer unit, and findings on the unit."""
    series = series_of(log, log.sensors[0])
    finer = finer_unit(series.time_s, series.mag_nT, series.gyro_rad_s, attitude_of(series))
    if finer is None:
        return log, []
    said = finer.words(log.sources.get("time_s", "time_s"))
    if not finer.sure:
        return log, [Finding(SECTION, "unit", finer.unit, "", said, "note")]
    columns = log.columns | {"time_s": UNITS["time"][finer.unit][0] * log.columns["time_s"]}
    told = Finding(SECTION, "unit", finer.unit, "", f"{said} This report takes them as {finer.unit}.", "warning")
    return replace(log, columns=columns), [told]


def find_gaps(time_s: Array) -> list[Gap]:
    """Return pauses in increasing times (n,)."""
    step = np.diff(time_s)
    if len(step) < 2:
        return []
    long = step > _longest_usual(step)
    return [Gap(float(t), float(s)) for t, s in zip(time_s[:-1][long], step[long], strict=True)]


def _longest_usual(step: Array) -> float:
    """Return the longest interval that is not a gap: 1.5 times the median, or the 95 % quantile if larger."""
    return POLICY.gap * float(max(np.median(step), np.quantile(step, 0.95)))


def _samples(stamps: Array, time_s: Array) -> Finding:
    length_s = float(np.ptp(time_s)) if len(time_s) else 0.0
    text = f"{counted(len(stamps), 'sample')} over {duration(length_s)}."
    few = len(time_s) < POLICY.few_samples
    if few:
        text += " Too few to judge noise, tones and slow changes."
    return Finding(SECTION, "samples", len(stamps), "", text, "note" if few else "ok")


def _interval(time_s: Array) -> Finding:
    interval_s = float(np.median(np.diff(time_s)))
    rate = f" ({figure(1 / interval_s, 4)} Hz)" if interval_s < SLOW_S else ""
    text = f"The median interval is {duration(interval_s)}{rate}."
    return Finding(SECTION, "interval", interval_s, "s", text)


def _jitter(time_s: Array) -> Finding:
    """Return the rms deviation of the intervals from the median, without gaps."""
    step = np.diff(time_s)
    usual = float(np.median(step))
    kept = step[step <= _longest_usual(step)]
    jitter_s = float(np.sqrt(np.mean((kept - usual) ** 2)))
    share = jitter_s / usual
    if share < POLICY.constant_jitter:
        told_s = jitter_s if jitter_s > np.spacing(np.abs(time_s).max()) else 0.0  # of the times' own digits
        return Finding(SECTION, "jitter", told_s, "s", "The interval is constant.")
    text = (
        f"The interval varies by {figure(100 * share, 2)} % rms, from {duration(kept.min())} to {duration(kept.max())}"
    )
    rounding_s = _rounding_s(time_s, kept)
    if rounding_s > 0 and jitter_s < rounding_s:
        text += f": no more than the time stamps' rounding to {duration(rounding_s)}"
        return Finding(SECTION, "jitter", jitter_s, "s", text + ".")
    level: Level = "warning" if share > POLICY.jitter_warning else "note" if share > POLICY.jitter_note else "ok"
    if level == "warning":
        text += ": sampling is irregular; spectra and filters that assume even sampling do not hold"
    return Finding(SECTION, "jitter", jitter_s, "s", text + ".", level)


def _rounding_s(time_s: Array, intervals: Array) -> float:
    """Return the rounding of the time stamps in s, 0 if unknown.

    An even clock with coarse stamps has two or three different intervals, apart by the rounding.
    """
    lengths = np.unique(np.round(intervals, RESOLUTION_DIGITS))
    if 1 < len(lengths) <= POLICY.few_lengths:
        step_s = float(np.diff(lengths).min())
    else:
        lattice = find_lattice(time_s)
        step_s = lattice.step if lattice and not lattice.floating else 0.0
    return step_s if step_s < float(np.median(intervals)) / 2 else 0.0


def _gaps(time_s: Array) -> Finding:
    gaps = find_gaps(time_s)
    if not gaps:
        return Finding(SECTION, "gaps", [], "s", "No gap between samples.")
    longest = max(gaps, key=lambda gap: gap.length_s)
    total_s = sum(gap.length_s for gap in gaps)
    text = f"{counted(len(gaps), 'gap')}, {duration(total_s)} together; the longest, {duration(longest.length_s)}, "
    text += f"begins at {figure(longest.after_s, 6)} s."
    listed = sorted(sorted(gaps, key=lambda gap: -gap.length_s)[:MOST_LISTED], key=lambda gap: gap.after_s)
    value = [{"after_s": gap.after_s, "length_s": gap.length_s} for gap in listed]
    share = total_s / float(np.ptp(time_s))
    return Finding(SECTION, "gaps", value, "s", text, "warning" if share > POLICY.most_gaps else "note")


def _order(stamps: Array) -> Finding:
    """Return counts of missing, repeated and decreasing time stamps."""
    missing = int(np.count_nonzero(~np.isfinite(stamps)))
    rows = np.flatnonzero(np.isfinite(stamps))
    step = np.diff(stamps[rows])
    counts = {"missing": missing, "repeated": int(np.sum(step == 0)), "decreasing": int(np.sum(step < 0))}
    listed = [f"{number} {name}" for name, number in counts.items() if number]
    if not listed:
        return Finding(SECTION, "order", counts, "", "Time stamps increase strictly.")
    text = f"Time stamps: {', '.join(listed)}"
    if (step <= 0).any():
        text += f"; the first in row {rows[int(np.argmax(step <= 0)) + 1] + 1}"
    text += ". Sort the rows, or cut the file where a new recording begins." if counts["decreasing"] else "."
    return Finding(SECTION, "order", counts, "", text, "warning")
