"""The values themselves: empty cells, least significant bit, full scale, frozen stretches, spikes."""

from __future__ import annotations

import numpy as np

from validation.inspection.finding import Finding
from validation.inspection.log import RawLog
from validation.inspection.sensor_data import LEAST_ROWS, Look
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.intervals import gaps_after
from validation.signals.lattice import odd_share
from validation.text import counted, duration, figure, figures

SECTION = "values"
COARSE_STEP = 2.0
"""A step of so many standard deviations of noise hides the noise."""
FINE_STEP = 0.1
"""A step below this share of the noise does no harm."""
ON_LATTICE = 0.999
"""Share of the values beyond which all are said to be multiples of the step."""
MOST_LISTED = 20
MOST_GAP_SHARE = 0.1
"""Share of the samples before a gap, beyond which neighbours tell nothing."""


def missing_finding(log: RawLog) -> Finding:
    """Empty cells, NaN and infinities by column."""
    counts = {name: int(np.count_nonzero(~np.isfinite(values))) for name, values in log.columns.items()}
    counts = {name: count for name, count in counts.items() if count}
    if not counts:
        return Finding(SECTION, "missing", {}, "cells", "No cell is empty.")
    listed = ", ".join(f"{name} {count:,}" for name, count in counts.items())
    needed = any(name == "time_s" or name.startswith("mag") for name in counts)
    text = f"Empty or infinite cells: {listed}."
    return Finding(SECTION, "missing", counts, "cells", text, "warning" if needed else "note")


def value_findings(look: Look) -> list[Finding]:
    """Lattice, full scale, frozen stretches and spikes of one magnetometer."""
    if len(look.series) < 3:
        return []
    found = [_constant(look), _lattice(look), _preferred(look), _full_scale(look), _frozen(look), _spikes(look)]
    return [finding for finding in found if finding is not None]


def _constant(look: Look) -> Finding | None:
    stuck = [axis for axis, width in zip("xyz", np.ptp(look.series.mag_nT, axis=0), strict=True) if width == 0]
    if not stuck:
        return None
    axes = "All three axes are" if len(stuck) == 3 else f"Axis {' and '.join(stuck)} is"
    text = f"{axes} constant: the sensor did not measure, or its column is another's."
    return Finding(SECTION, "constant", stuck, "", text, "warning", look.sensor)


def _lattice(look: Look) -> Finding:
    steps = [lattice.step if lattice else float("nan") for lattice in look.lattices]
    if not np.isfinite(steps).any():
        text = "No least significant bit shows: it is below the log's last digit, or later arithmetic hid it."
        return Finding(SECTION, "step", steps, "nT", text, "ok", look.sensor)
    if any(lattice and lattice.floating for lattice in look.lattices):
        text = f"Steps grow with the value, {figures(steps)} nT at least: the log keeps a fixed number of digits."
        return Finding(SECTION, "step", steps, "nT", text, "note", look.sensor)
    noise = np.where(look.white_nT > 0, look.white_nT, np.nan)  # an axis that never changes tells nothing
    coarsest = float(np.nanmax(np.array(steps) / noise, initial=0.0))
    text = f"Least significant bit {figures(steps, 5)} nT{_off_lattice(look)}{_against_noise(coarsest)}."
    return Finding(SECTION, "step", steps, "nT", text, "note" if coarsest > COARSE_STEP else "ok", look.sensor)


def _off_lattice(look: Look) -> str:
    """How many values are no multiple of the step, where some are not."""
    share = min(lattice.share for lattice in look.lattices if lattice)
    return f"; {100 - 100 * share:.2g} % of the values lie beside it" if share < ON_LATTICE else ""


def _against_noise(ratio: float) -> str:
    """A step that is this many times the noise, in words; nothing where the noise is not known."""
    if ratio > COARSE_STEP:
        return f", {figure(ratio, 2)} times the noise: neighbouring samples differ by rounding rather than by noise"
    harm = ": it does no harm" if ratio < FINE_STEP else ""
    return f", {figure(ratio, 2)} of the noise{harm}" if ratio > 0 else ""


def _preferred(look: Look) -> Finding | None:
    """Every second code rarer than its neighbours: values between the converter's were made by averaging."""
    shares, steps = [], []
    for lattice, column in zip(look.lattices, look.series.mag_nT[look.fresh].T, strict=True):
        if lattice is not None and not lattice.floating:
            share = odd_share(np.rint((column - lattice.offset) / lattice.step).astype(np.int64))
            shares.append(min(share, 1 - share))
            steps.append(2 * lattice.step)
    if not shares or min(shares) == 0.5:
        return None
    text = f"Every second code is rarer, {figures(shares, 2)} of all: the converter's step is perhaps {figures(steps)} "
    text += "nT, and the codes between were averaged or interpolated from it."
    return Finding(SECTION, "preferred_codes", shares, "", text, "note", look.sensor)


def _full_scale(look: Look) -> Finding:
    found = pile_up(look.series.mag_nT, look.lattices)
    value = [{"axis": "xyz"[p.axis], "side": p.side, "level_nT": p.level, "samples": p.count} for p in found]
    if not found:
        return Finding(SECTION, "full_scale", value, "nT", "No axis stands at a full scale.", "ok", look.sensor)
    listed = ", ".join(f"{'xyz'[p.axis]} at {figure(p.level, 6)} nT ({counted(p.count, 'sample')})" for p in found)
    text = f"Cut off at full scale: {listed}; leave these samples out, or choose a wider range."
    return Finding(SECTION, "full_scale", value, "nT", text, "warning", look.sensor)


def _frozen(look: Look) -> Finding:
    """Stretches that repeat one row, of the rows that a slower sensor does not repeat anyway."""
    series = look.series
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
        return Finding(SECTION, "frozen", value, "", text, "warning", look.sensor)
    share = 100 * found.repeated / len(series)
    text = "No stretch is frozen"
    text += f"; {share:.2g} % of the rows repeat the one before." if found.repeated else ", and no row is repeated."
    return Finding(SECTION, "frozen", value, "", text, "ok", look.sensor)


def _spikes(look: Look) -> Finding | None:
    """Single wrong values; where neighbours are too far apart nothing can be said."""
    series, rows = look.series, look.fresh
    gaps = gaps_after(series.time_s[rows])
    if not np.isfinite(look.white_nT).all() or len(rows) < LEAST_ROWS or len(gaps) > MOST_GAP_SHARE * len(rows):
        return None
    steps = np.array([lattice.step if lattice else 0.0 for lattice in look.lattices])
    found = spikes(series.mag_nT[rows], steps, gaps)
    count = int(found.sum())
    value = {axis: int(n) for axis, n in zip("xyz", found.sum(axis=0), strict=True)}
    if not count:
        return Finding(SECTION, "spikes", value, "", "No spike stands out from its neighbours.", "ok", look.sensor)
    first = float(series.time_s[rows[int(np.argmax(found.any(axis=1)))]])
    text = f"{counted(count, 'spike')} of a single sample, 8 or more standard deviations from the neighbours; "
    text += f"the first at {figure(first, 6)} s."
    return Finding(SECTION, "spikes", value, "", text, "warning", look.sensor)
