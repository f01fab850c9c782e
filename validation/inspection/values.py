"""Values: empty cells, least significant bit, full scale, frozen stretches, spikes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from validation.inspection.finding import Finding
from validation.inspection.log import RawLog
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.signals.faults import repeats, spikes
from validation.signals.intervals import gaps_after
from validation.signals.lattice import odd_share
from validation.text import counted, duration, figure, figures, sentence

SECTION = "values"
MOST_COLUMNS = 4
"""Columns with empty cells that a sentence names."""
MOST_LISTED = 20
"""Frozen stretches that are listed."""


def missing_finding(log: RawLog) -> Finding:
    """Return numbers of empty cells, NaN and infinities by column."""
    counts = {name: int(np.count_nonzero(~np.isfinite(values))) for name, values in log.as_found.items()}
    counts = {name: count for name, count in counts.items() if count}
    if not counts:
        return Finding(SECTION, "missing", {}, "cells", "No cell is empty.")
    most = [f"{name} {count}" for name, count in counts.items()][:MOST_COLUMNS]
    listed = ", ".join(most) + (f" and in {len(counts) - len(most)} more columns" if len(counts) > len(most) else "")
    needed = any(name == "time_s" or name.startswith("mag") for name in counts)
    text = f"Empty or infinite cells: {listed}."
    return Finding(SECTION, "missing", counts, "cells", text, "warning" if needed else "note")


def value_findings(data: SensorData) -> list[Finding]:
    """Return findings on converter steps, full scale, frozen stretches and spikes of a magnetometer."""
    if len(data.series) < 3:
        return []
    found = [_constant(data), _lattice(data), _preferred(data), _full_scale(data), _frozen(data), _spikes(data)]
    return [finding for finding in (*found, *_faults(data)) if finding is not None]


def _faults(data: SensorData) -> list[Finding]:
    """Return the faults that screening finds before a calibration, without those with a finding of their own."""
    told = ("full_scale", "frozen", "held")
    return [
        Finding(SECTION, fault.kind, fault.summary(), "", sentence(fault.told), "warning", data.sensor)
        for fault in data.judged.faults
        if fault.kind not in told
    ]


def _constant(data: SensorData) -> Finding | None:
    measured = data.judged.recording.origin.axes
    widths = dict(zip("xyz", np.ptp(data.series.mag_nT, axis=0), strict=True))
    stuck = [axis for axis in measured if widths[axis] == 0]
    if not stuck:
        return None
    axes = "All three axes are" if len(stuck) == 3 else f"Axis {' and '.join(stuck)} is"
    text = f"{axes} constant: the sensor did not measure, or the column is wrong."
    return Finding(SECTION, "constant", stuck, "", text, "warning", data.sensor)


def _lattice(data: SensorData) -> Finding:
    steps = [lattice.step if lattice else float("nan") for lattice in data.lattices]
    if not np.isfinite(steps).any():
        text = "No least significant bit is visible: below the last digit of the log, or hidden by later arithmetic."
        return Finding(SECTION, "step", steps, "nT", text, "ok", data.sensor)
    if any(lattice and lattice.floating for lattice in data.lattices):
        text = f"Steps grow with the value, from {figures(steps)} nT: the log keeps a fixed number of digits."
        return Finding(SECTION, "step", steps, "nT", text, "note", data.sensor)
    noise = np.where(data.white_nT > 0, data.white_nT, np.nan)  # a constant axis has no noise
    coarsest = float(np.nanmax(np.array(steps) / noise, initial=0.0))
    text = f"Least significant bit {figures(steps, 5)} nT{_off_lattice(data)}{_against_noise(coarsest)}."
    return Finding(SECTION, "step", steps, "nT", text, "note" if coarsest > POLICY.coarse_step else "ok", data.sensor)


def _off_lattice(data: SensorData) -> str:
    """Return the share of values off the lattice, in words."""
    share = min(lattice.share for lattice in data.lattices if lattice)
    return (
        f"; {figure(100 - 100 * share, 2)} % of the values are not multiples" if share < POLICY.all_on_lattice else ""
    )


def _against_noise(ratio: float) -> str:
    """Return the ratio of step to noise in words, "" if unknown."""
    if ratio > POLICY.coarse_step:
        return f", {figure(ratio, 2)} times the noise: rounding dominates the noise of neighbouring samples"
    harm = ": harmless" if ratio < POLICY.fine_step else ""
    return f", {figure(ratio, 2)} of the noise{harm}" if ratio > 0 else ""


def _preferred(data: SensorData) -> Finding | None:
    """Return a finding if every second code is rare: averaging made values between the converter's."""
    shares, steps = [], []
    for lattice, column in zip(data.lattices, data.series.mag_nT[data.fresh].T, strict=True):
        if lattice is not None and not lattice.floating:
            share = odd_share(np.rint((column - lattice.offset) / lattice.step).astype(np.int64))
            shares.append(min(share, 1 - share))
            steps.append(2 * lattice.step)
    if not shares or min(shares) == 0.5:
        return None
    text = f"Every second code is rare, {figures(shares, 2)} of all: the converter's step is perhaps {figures(steps)} "
    text += "nT, and averaging or interpolation made the codes between."
    return Finding(SECTION, "preferred_codes", shares, "", text, "note", data.sensor)


def _full_scale(data: SensorData) -> Finding:
    found = [end for fault in data.judged.faults if fault.kind == "full_scale" for end in fault.detail]
    if not found:
        return Finding(SECTION, "full_scale", found, "nT", "No axis is cut off at full scale.", "ok", data.sensor)
    ends = (f"{e['axis']} at {figure(e['level_nT'], 6)} nT ({counted(e['samples'], 'sample')})" for e in found)
    text = f"Cut off at full scale: {', '.join(ends)}. Leave the samples out, or choose a wider range."
    return Finding(SECTION, "full_scale", found, "nT", text, "warning", data.sensor)


def _frozen(data: SensorData) -> Finding:
    """Return stretches of equal rows that a slower sensor does not explain."""
    series = data.series
    found = repeats(series.mag_nT)
    value = [
        {"at_s": float(series.time_s[first]), "samples": rows, "row": int(series.rows[first]) + 1}
        for first, rows in found.frozen[:MOST_LISTED]
    ]
    if found.frozen:
        rows = sum(count for _, count in found.frozen)
        longest = max(found.frozen, key=lambda one: one[1])
        last = min(longest[0] + longest[1], len(series) - 1)
        text = f"Frozen {counted(len(found.frozen), 'time')}, {counted(rows, 'sample')} together; the longest, "
        text += f"{duration(float(series.time_s[last] - series.time_s[longest[0]]))}, begins at "
        text += f"{figure(float(series.time_s[longest[0]]), 6)} s."
        return Finding(SECTION, "frozen", value, "", text, "warning", data.sensor)
    share = 100 * found.repeated / len(series)
    text = "The sensor as a whole is never frozen"
    text += (
        f"; {figure(share, 2)} % of the rows repeat the previous row."
        if found.repeated
        else ", and no row is repeated."
    )
    return Finding(SECTION, "frozen", value, "", text, "ok", data.sensor)


def _spikes(data: SensorData) -> Finding | None:
    """Return wild values that a fit leaves out, without a fit single wrong values; None where none can be judged."""
    series, rows = data.series, data.fresh
    gaps = gaps_after(series.time_s[rows])
    far_apart = not np.isfinite(data.white_nT).all() or len(gaps) > POLICY.most_gap_share * len(rows)
    if far_apart or len(rows) < POLICY.least_rows:
        return None
    return _wild(data) if data.ellipsoid.has_estimate else _apart_from_neighbours(data, gaps)


def _wild(data: SensorData) -> Finding:
    """Return the samples that the ellipsoid's fit left out, by the axis that leaves its neighbours furthest."""
    recording, left_out = data.judged.recording, data.ellipsoid.left_out
    rows = np.zeros(0, np.intp) if left_out is None else np.flatnonzero(left_out)
    beside = np.clip(rows[:, None] + np.arange(-2, 3), 0, len(recording) - 1)
    away = recording.mag_nT[rows] - np.median(recording.mag_nT[beside], axis=1)
    counts = np.bincount(np.argmax(np.abs(away), axis=1), minlength=3) if len(rows) else np.zeros(3, np.intp)
    value = {axis: int(n) for axis, n in zip("xyz", counts, strict=True)}
    if not len(rows):
        return Finding(SECTION, "spikes", value, "", "No spikes.", "ok", data.sensor)
    text = f"{counted(len(rows), 'wild value')}, up to {figure(float(np.abs(away).max()))} nT from the neighbours, "
    text += f"the first at {figure(float(recording.time_s[rows[0]]), 6)} s; a calibration leaves them out."
    return Finding(SECTION, "spikes", value, "", text, "warning", data.sensor)


def _apart_from_neighbours(data: SensorData, gaps: NDArray[np.intp]) -> Finding:
    """Return single values far from the course of their neighbours."""
    series, rows = data.series, data.fresh
    steps = np.array([lattice.step if lattice else 0.0 for lattice in data.lattices])
    found = spikes(series.mag_nT[rows], steps, gaps)
    count = int(found.sum())
    value = {axis: int(n) for axis, n in zip("xyz", found.sum(axis=0), strict=True)}
    if not count:
        return Finding(SECTION, "spikes", value, "", "No spikes.", "ok", data.sensor)
    first = float(series.time_s[rows[int(np.argmax(found.any(axis=1)))]])
    text = f"{counted(count, 'spike')} of a single sample, {POLICY.spike_sigma:g} or more standard deviations "
    text += "from the neighbours; "
    text += f"the first at {figure(first, 6)} s."
    return Finding(SECTION, "spikes", value, "", text, "warning", data.sensor)
