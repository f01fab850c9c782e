"""Plots of a diagnosis: gap before and after over time, along the path, by frequency and by channel; evidence."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from reports.palette import AFTER, BEFORE, RAW, SOFT
from reports.plots.style import clip_outliers, label_decades, panels, time_scale
from reports.presentation.diagnosis import PresentedDiagnosis
from reports.presentation.series import GapSeries, block_length, block_means
from scenarios.arrays import Array
from validation.signals.thinning import every_nth
from validation.text import plainly

FINE, COARSE, MOST_POINTS = 1500, 200, 4000
"""Points of the pale and of the bold lines over time, and of a cloud."""
LEAST_HEIGHT_M, LEAST_SHARE = 0.5, 0.02
"""A path's height is drawn from this extent on, and from this share of the horizontal one."""
BINS, LEAST_IN_BIN = 24, 8
ENDS = (0.01, 0.99)
"""Quantiles of a channel between which the means are drawn."""
DIRECTIONS = ("east", "north", "up")
Sides = tuple[tuple[str, str, str], ...]
"""Side, colour and label of the curves of a gap."""
BOTH: Sides = (("before", BEFORE, "before"), ("after", AFTER, "after"))
EQUAL: Sides = (("before", BEFORE, "before and after, equal"),)


def draw_gap(found: PresentedDiagnosis) -> Figure:
    """Draw measured minus simulated over time, before and after: means over short (pale) and long (bold) blocks."""
    series, gap = found.series, found.series.displayed
    count = len(series.outputs)
    figure, axes = panels(1.7 * count + 0.8, count, sharex=True, squeeze=False)
    axes = axes[:, 0]
    scale, unit = time_scale(series.time_s)
    gaps, least = thinned(gap), series.residual.thinned(FINE).before_nT
    for k, (axis, label) in enumerate(zip(axes, series.outputs, strict=True)):
        draw_output(axis, gaps, k, _sides(gap.before_nT, gap.after_nT), scale)
        clip_outliers(axis, least[:, k])
        axis.set_ylabel(f"{label} (nT)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    how = "models without refit" if series.hidden else "iron refitted"
    axes[0].set_title(f"Measured minus simulated, {how}")
    axes[-1].set(xlabel=f"time ({unit})", xlim=(series.time_s[0] / scale, series.time_s[-1] / scale))
    return figure


def thinned(gap: GapSeries) -> tuple[GapSeries, GapSeries]:
    """Return a gap as means over short and over long blocks."""
    return gap.thinned(FINE), gap.thinned(COARSE)


def draw_output(axis: Any, gaps: tuple[GapSeries, GapSeries], k: int, sides: Sides, scale: float = 1.0) -> None:
    """Draw output k of a thinned gap over time, short blocks pale and long blocks bold; scale: seconds in a unit."""
    fine, coarse = gaps
    for side, colour, label in sides:
        axis.plot(fine.time_s / scale, fine.sides[side][:, k], color=colour, alpha=0.3)
        axis.plot(coarse.time_s / scale, coarse.sides[side][:, k], color=colour, linewidth=1.6, label=label)


def draw_map(found: PresentedDiagnosis) -> Figure:
    """Draw the size of the gap along the path, before and after: from above, and from the side if height changes."""
    path, pos_m = found.series.path, found.series.pos_m
    assert pos_m is not None
    assert path.pos_m is not None
    planes = _planes(path_m := pos_m[every_nth(len(pos_m), MOST_POINTS)])
    sizes = {label: np.linalg.norm(path.gap.sides[side], axis=1) for side, _, label in _sides(*path.gap.sides.values())}
    figure, axes = panels(3.6 * len(planes) + 0.2, len(planes), len(sizes), sharex="row", sharey="row", squeeze=False)
    most = max(float(np.nanquantile(next(iter(sizes.values())), 0.98)), 1e-9)
    for plane, row in zip(planes, axes, strict=True):
        for axis, (side, size) in zip(row, sizes.items(), strict=True):
            axis.plot(*path_m[:, plane].T, color=RAW, linewidth=0.4, zorder=1)
            dots = _draw_places(axis, path.pos_m[:, plane], size, most)
            _label_plane(axis, plane, side)
        row[0].set_ylabel(f"{DIRECTIONS[plane[1]]} (m)")
    scale = figure.colorbar(dots, ax=axes, shrink=0.8, pad=0.01, extend="max")
    scale.set_label(f"size of the gap (nT); noise alone: {path.noise_nT:.2g}")
    return figure


def _planes(path_m: Array) -> list[list[int]]:
    """Return the planes of view: from above, and from the path's longer side where the height changes."""
    extent = np.ptp(path_m, axis=0)
    rises = extent[2] > max(LEAST_HEIGHT_M, LEAST_SHARE * extent[:2].max())
    return [[0, 1], [int(extent[1] > extent[0]), 2]] if rises else [[0, 1]]


def _draw_places(axis: Any, places_m: Array, size: Array, most: float) -> Any:
    """Draw dots (m, 2) coloured by size (m,), large values on top."""
    order = np.argsort(size)
    x, y = places_m[order].T
    style = {"s": 7, "cmap": "viridis_r", "linewidths": 0, "zorder": 2, "rasterized": True}
    return axis.scatter(x, y, c=size[order], vmin=0, vmax=most, **style)


def _label_plane(axis: Any, plane: list[int], title: str) -> None:
    """Label a view; the limits of the only view of a row fill the row."""
    alone = axis.get_subplotspec().get_gridspec().ncols == 1
    above = plane == [0, 1]
    axis.set(xlabel=f"{DIRECTIONS[plane[0]]} (m)", title=f"{'From above' if above else 'From the side'}, {title}")
    if above:
        axis.set_aspect("equal", adjustable="datalim" if alone else "box")


def draw_spectrum(found: PresentedDiagnosis) -> Figure:
    """Draw the amplitude density of the gap before and after, with the white noise of a sample."""
    figure, axis = panels(3.2)
    spectrum = found.series.spectrum
    for side, colour, label in _sides(spectrum.before, spectrum.after):
        axis.loglog(spectrum.frequency_Hz, getattr(spectrum, side), color=colour, label=label)
    axis.axhline(spectrum.level, color=SOFT, linestyle="--", label="noise of a sample")
    label_decades(axis.yaxis)
    axis.set(xlabel="frequency (Hz)", ylabel="nT/√Hz")
    axis.legend()
    return figure


def draw_channel(found: PresentedDiagnosis) -> Figure:
    """Draw the largest component of the gap against the channels that the gap follows: means as dots, bins as lines."""
    series, gap = found.series, found.series.displayed
    channels = list(series.channels.items())[:3] or [("time_s", series.time_s)]
    thin, output = gap.thinned(MOST_POINTS), gap.largest
    figure, (axes,) = panels(3.2, 1, len(channels), sharey=True, squeeze=False)
    for axis, (name, values) in zip(axes, channels, strict=True):
        channel = block_means(values, block_length(len(values), MOST_POINTS))
        for side, colour, label in _sides(gap.before_nT, gap.after_nT):
            component = thin.sides[side][:, output]
            axis.plot(channel, component, ".", markersize=2, color=colour, alpha=0.3)
            axis.plot(*_binned(channel, component), color=colour, linewidth=2.0, label=label)
        axis.set_xlabel(name)
    axes[0].set_ylabel(f"{series.outputs[output]} (nT)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def draw_ranking(found: PresentedDiagnosis) -> Figure:
    """Draw the evidence of every candidate in the first round, in nats on a signed logarithmic scale."""
    rows = found.ranking[:12][::-1]
    colour = {other: BEFORE for cause in found.causes for other in cause.alternatives}
    colour |= {cause.name: AFTER for cause in found.causes}
    figure, axis = panels(0.26 * max(len(rows), 2) + 0.9)
    for y, one in enumerate(rows):
        bar = axis.barh(y, one.nats, color=colour.get(one.name, RAW))
        axis.bar_label(bar, [f"{one.evidence.strength:.2g} x noise"], padding=3, fontsize=8, color=SOFT)
        axis.plot(one.needed, y, "|", color=SOFT, markersize=10)
    axis.set_yticks(range(len(rows)), [one.name for one in rows])
    axis.set_xscale("symlog", linthresh=5)
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plainly(value)))
    axis.margins(x=0.12)
    axis.set_xlabel("evidence on held-out data (nats); tick: evidence needed; number: rms of the effect")
    return figure


def _sides(before: Array, after: Array) -> Sides:
    """Return the curves of a gap before and after; a single curve where the gaps are equal."""
    return EQUAL if np.array_equal(before, after, equal_nan=True) else BOTH


def _binned(channel: Array, values: Array) -> tuple[Array, Array]:
    """Return the means of channel and values over stretches of equal width that hold LEAST_IN_BIN values."""
    known = np.isfinite(values) & np.isfinite(channel)
    low, high = np.quantile(channel[known], ENDS) if known.any() else (0.0, 0.0)
    edges = np.linspace(low, high, BINS + 1 if known.any() else 1)
    place = np.where(known, np.searchsorted(edges, channel, side="right"), 0)
    parts = [part for number in range(1, len(edges)) if (part := place == number).sum() >= LEAST_IN_BIN]
    return tuple(np.array([of[part].mean() for part in parts]) for of in (channel, values))  # type: ignore[return-value]
