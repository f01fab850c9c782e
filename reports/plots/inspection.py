"""Plots of an inspection: coverage, strength, residual, spectrum, Allan deviation, low digits."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from calib.numerics.noise import white_noise_std
from reports.palette import INK, LINES, RAW, SOFT, XYZ
from reports.plots.style import clip_outliers, legend_at_right, panels, time_scale
from scenarios.arrays import Array
from validation.inspection.sensor_data import SensorData
from validation.inspection.timing import find_gaps
from validation.signals.noise import allan_deviation
from validation.signals.sphere import cells, directions
from validation.signals.thinning import envelope, every_nth
from validation.signals.tones import Spectrum, Tone, mains_aliases, spectrum, tones

MOST_POINTS = 6000
CODES = 16
EDGE_STEPS = 8
"""Straight pieces that draw a cell's edge."""
MOST_TONES = 8
AFTER_FIT = LINES[3]
"""Colour of the strength after the ellipsoid fit, none of the components' colours."""


def draw_coverage(data: SensorData) -> Figure:
    """Draw the directions of the field in the body frame on two discs of equal area: cells with samples, and points."""
    corrected = data.corrected_nT
    return draw_directions(data.series.mag_nT if corrected is None else corrected)


def draw_directions(field_nT: Array) -> Figure:
    """Draw the directions of fields (n, 3) on two discs of equal area: cells with samples, and points."""
    figure, axes = panels(5.2, 1, 2)
    seen = directions(field_nT)
    entered = np.zeros(cells().total, np.bool_)
    entered[cells().index(seen)] = True
    for axis, sign, title in zip(axes, (1, -1), ("upper half, +z", "lower half, −z"), strict=True):
        _disc(axis, sign, entered)
        half = seen[sign * seen[:, 2] >= 0]
        axis.scatter(*_flat(half[every_nth(len(half), MOST_POINTS)]).T, s=3, color=INK, linewidths=0, rasterized=True)
        axis.set_title(title)
    return figure


def _disc(axis: Any, sign: int, entered: Any) -> None:
    """Draw the cells of one half of the sphere, filled where samples lie, and the body axes."""
    for filled, colour in ((True, "#cfe3f1"), (False, "white")):
        rows = cells().edges()[entered == filled]
        polygons = [_flat(_outline(*row)) for row in rows if sign * (row[2] + row[3]) > 0]
        axis.add_collection(PolyCollection(polygons, facecolors=colour, edgecolors="#e3e7eb", linewidths=0.5))
    angle = np.linspace(0, 2 * np.pi, 200)
    axis.plot(np.cos(angle), np.sin(angle), color=SOFT, linewidth=0.8)
    for x, y, name in ((1, 0, "+x"), (0, 1, "+y"), (-1, 0, "−x"), (0, -1, "−y")):
        axis.annotate(name, (1.07 * x, 1.07 * y), ha="center", va="center", color=SOFT)
    axis.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), aspect="equal")
    axis.axis("off")


def _outline(low: float, high: float, bottom: float, top: float) -> Array:
    """Return unit vectors (m, 3) along the edge of a cell."""
    turn, height = np.linspace(low, high, EDGE_STEPS), np.linspace(bottom, top, EDGE_STEPS)
    longitude = np.r_[turn, np.full(EDGE_STEPS, high), turn[::-1], np.full(EDGE_STEPS, low)]
    z = np.r_[np.full(EDGE_STEPS, bottom), height, np.full(EDGE_STEPS, top), height[::-1]]
    radius = np.sqrt(np.clip(1 - z**2, 0, 1))
    return np.column_stack([radius * np.cos(longitude), radius * np.sin(longitude), z])


def _flat(direction: Array) -> Array:
    """Return Lambert's azimuthal equal-area map (n, 2) of unit vectors (n, 3), about the nearer pole."""
    scale = 1.0 / np.sqrt(1.0 + np.minimum(np.abs(direction[:, 2]), 1.0))
    return direction[:, :2] * scale[:, None]


def draw_strength(data: SensorData) -> Figure:
    """Draw components and strength over time with gaps shaded, and the strength after an ellipsoid fit."""
    series, corrected = data.series, data.corrected_nT
    figure, (parts, whole) = panels(5.0, 2, 1, sharex=True)
    for k, colour in enumerate(XYZ):
        _line(parts, series.time_s, series.mag_nT[:, k], color=colour, label="xyz"[k])
    strength = np.linalg.norm(series.mag_nT, axis=1)
    _line(whole, series.time_s, strength, color=RAW, label="as measured")
    if corrected is not None:
        _line(whole, series.time_s, np.linalg.norm(corrected, axis=1), color=AFTER_FIT, label="after ellipsoid fit")
    scale, unit = time_scale(series.time_s)
    for axis, label in ((parts, "field (nT)"), (whole, "strength (nT)")):
        for gap in find_gaps(series.time_s):
            axis.axvspan(gap.after_s / scale, (gap.after_s + gap.length_s) / scale, color="#f2b8a0", alpha=0.6, lw=0)
        axis.set_ylabel(label)
        legend_at_right(axis)
    whole.set_xlabel(f"time ({unit}); gaps are shaded")
    return figure


def _line(axis: Any, time_s: Array, values: Array, **style: Any) -> None:
    """Draw a thinned line over time, broken at the gaps."""
    scale, _ = time_scale(time_s)
    cuts = [np.searchsorted(time_s, gap.after_s, side="right") for gap in find_gaps(time_s)][:200]
    label = style.pop("label", None)
    for times, part in zip(np.split(time_s, cuts), np.split(values, cuts), strict=True):
        axis.plot(*envelope(times / scale, part), label=label, **style)
        label = None


def draw_residual(data: SensorData) -> Figure:
    """Draw the residual of the base model over time."""
    assert data.residual is not None
    residual = data.residual
    figure, axis = panels(2.6)
    for k, colour in enumerate(XYZ[: residual.values.shape[1]]):
        _line(axis, residual.time_s, residual.values[:, k], color=colour, alpha=0.8, label=_label(data, k))
    clip_outliers(axis, residual.values)
    axis.set(xlabel=f"time ({time_scale(residual.time_s)[1]})", ylabel="residual (nT)")
    legend_at_right(axis)
    return figure


def _label(data: SensorData, k: int) -> str:
    assert data.residual is not None
    return "strength" if data.residual.base == "strength" else "xyz"[k]


def draw_spectrum(data: SensorData) -> Figure:
    """Draw the amplitude density of the residual, the local background, tones, and aliases of the mains."""
    assert data.residual is not None
    residual = data.residual
    found = spectrum(residual.time_s, residual.values)
    figure, axis = panels(3.4)
    if found is None:
        return figure
    _draw_density(axis, data, found)
    _mark_tones(axis, tones(residual.time_s, residual.values)[:MOST_TONES])
    _mark_mains(axis, data.rate_hz, float(found.frequency_hz[1]))
    axis.set(xlabel="frequency (Hz)", ylabel="nT/√Hz", xlim=(found.frequency_hz[1], found.frequency_hz[-1]))
    legend_at_right(axis)
    return figure


def _draw_density(axis: Any, data: SensorData, found: Spectrum) -> None:
    """Draw the amplitude density of each axis, pale, and the local background, bold."""
    for k, colour in enumerate(XYZ[: found.density.shape[1]]):
        frequency, density = envelope(found.frequency_hz[1:], np.sqrt(found.density[1:, k]), 1500)
        axis.loglog(frequency, density, color=colour, linewidth=0.5, alpha=0.6)
        background = _thinned(found.frequency_hz[1:], np.sqrt(found.background[1:, k]))
        axis.loglog(*background, color=colour, linewidth=1.6, label=_label(data, k))
    floor = np.sqrt(found.background[found.background > 0])
    if floor.size:
        axis.set_ylim(bottom=floor.min() / 10)


def _mark_tones(axis: Any, found: list[Tone]) -> None:
    for tone in found:
        axis.axvline(tone.frequency_hz, color=INK, linewidth=0.7, linestyle=(0, (2, 2)))
        axis.annotate(
            f"{tone.frequency_hz:.4g}", (tone.frequency_hz, 1), xycoords=("data", "axes fraction"), xytext=(2, -2),
            textcoords="offset points", rotation=90, va="top", fontsize=7.5,
        )  # fmt: skip


def _mark_mains(axis: Any, rate_hz: float, lowest_hz: float) -> None:
    """Mark the aliases of 50 Hz and 60 Hz at the sample rate."""
    for name, side in (("50 Hz", "right"), ("60 Hz", "left")):
        alias = mains_aliases(rate_hz)[name]
        if alias > lowest_hz:
            axis.axvline(alias, ymax=0.05, color="#d55e00", linewidth=2)
            axis.annotate(f" {name} ", (alias, 0.02), xycoords=("data", "axes fraction"), ha=side, fontsize=7.5)


def _thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Return points of a curve that are about evenly spaced on a logarithmic axis."""
    rows = np.unique(np.round(np.geomspace(1, len(x), 400)).astype(int)) - 1
    return x[rows], y[rows]


def draw_allan(data: SensorData) -> Figure:
    """Draw the Allan deviation of the residual, and of white noise alone."""
    assert data.residual is not None
    residual = data.residual
    figure, axis = panels(3.2)
    interval_s = 1.0 / data.rate_hz
    tau_s, deviation = allan_deviation(interval_s, residual.values)
    for k, (colour, white) in enumerate(zip(XYZ, white_noise_std(residual.values), strict=False)):
        axis.loglog(tau_s, deviation[:, k], color=colour, marker="o", markersize=3, label=_label(data, k))
        axis.loglog(tau_s, white / np.sqrt(tau_s / interval_s), color=colour, linewidth=0.8, linestyle=(0, (4, 3)))
    axis.set(xlabel="averaging time (s)", ylabel="Allan deviation (nT)")
    legend_at_right(axis)
    return figure


def draw_low_digits(data: SensorData) -> Figure:
    """Draw how often each low digit occurs: the converter's last four bits, or the position within the noise."""
    figure, axes = panels(2.6, 1, 3)
    for k, (axis, lattice) in enumerate(zip(axes, data.lattices, strict=True)):
        values = data.series.mag_nT[data.fresh, k]
        if lattice is not None and not lattice.floating:
            code = np.rint((values - lattice.offset) / lattice.step).astype(np.int64) % CODES
            label = f"{'xyz'[k]}: code modulo {CODES}, a code {lattice.step:.4g} nT"
        else:
            unit = float(data.white_nT[k]) if np.isfinite(data.white_nT[k]) and data.white_nT[k] > 0 else 1.0
            code = np.floor(values / unit * 4).astype(np.int64) % CODES
            label = f"{'xyz'[k]}: value modulo {4 * unit:.3g} nT, in sixteenths"
        axis.bar(np.arange(CODES), np.bincount(code, minlength=CODES), color=XYZ[k], width=0.8)
        axis.axhline(len(code) / CODES, color=INK, linewidth=0.7, linestyle=(0, (4, 3)))
        axis.set(xlabel=label, ylabel="samples" if k == 0 else "", xticks=range(0, CODES, 4))
    return figure
