"""Pictures of a diagnosis: the gap before and after in time, along the path, by frequency and against channels."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from diagnosis.evidence.localise import channels
from diagnosis.result import Diagnosis
from reports.gap_series import (
    GapAlongPath,
    axes_of,
    block_length,
    block_means,
    displayed_gap,
    gap_along_path,
    hidden_by_iron_refit,
    relative_to_first,
)
from reports.palette import LINES, RAW, SOFT
from reports.plots.style import WIDTH_IN, clip_outliers
from scenarios.arrays import Array
from validation.signals.thinning import every_nth

BEFORE, AFTER = LINES[1], LINES[0]
FINE, COARSE, MOST_POINTS = 1500, 200, 4000
"""Points of the pale and of the bold lines over time, and of a cloud."""
LEAST_HEIGHT_M, LEAST_SHARE = 0.5, 0.02
"""A path's height is drawn from this extent on, and from this share of the horizontal one."""
BINS = 24
DIRECTIONS = ("east", "north", "up")


def draw_gap(found: Diagnosis) -> Figure:
    """Measured minus simulated over time, before and after: means over short (pale) and long (bold) parts."""
    labels = axes_of(found)
    figure = Figure(figsize=(WIDTH_IN, 1.7 * len(labels) + 0.8), layout="constrained")
    axes = figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0]
    time, unit = _time(found)
    for curve in _curves(*displayed_gap(found)):
        _draw_means(axes, found, time, curve)
    least = block_means(found.before_nT, block_length(len(time), FINE), found.problem.usable)
    for i, axis in enumerate(axes):
        clip_outliers(axis, least[:, i])
        axis.set_ylabel(f"{labels[i]} (nT)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    how = "the models as they stand" if hidden_by_iron_refit(found) else "iron fitted anew"
    axes[0].set_title(f"Measured minus simulated, {how}")
    axes[-1].set(xlabel=f"time ({unit})", xlim=(time[0], time[-1]))
    return figure


def _draw_means(axes: Any, found: Diagnosis, time: Array, curve: tuple[Array, str, str]) -> None:
    gap, colour, label = curve
    styles: tuple[tuple[int, dict[str, Any]], ...] = (
        (FINE, {"alpha": 0.3}),
        (COARSE, {"linewidth": 1.6, "label": label}),
    )
    for most, style in styles:
        length = block_length(len(gap), most)
        t, thin = block_means(time, length), block_means(gap, length, found.problem.usable)
        for i, axis in enumerate(axes):
            axis.plot(t, thin[:, i], color=colour, **style)


def draw_map(found: Diagnosis) -> Figure:
    """Size of the gap along the path, before and after: from above, and from the side where the height changes."""
    where, position = gap_along_path(found), found.problem.recording.pos_enu_m
    assert position is not None
    path_m = relative_to_first(position)[every_nth(len(position), MOST_POINTS)]
    planes = _planes(path_m)
    figure = Figure(figsize=(WIDTH_IN, 3.6 * len(planes) + 0.2), layout="constrained")
    axes = figure.subplots(len(planes), 2, sharex="row", sharey="row", squeeze=False)
    sizes = [np.linalg.norm(gap, axis=1) for gap in (where.before_nT, where.after_nT)]
    most = max(float(np.nanquantile(sizes[0], 0.98)), 1e-9)
    for plane, row in zip(planes, axes, strict=True):
        for axis, size, title in zip(row, sizes, ("before", "after"), strict=True):
            axis.plot(*path_m[:, plane].T, color=RAW, linewidth=0.4, zorder=1)
            dots = _draw_places(axis, where, plane, size, most)
            _label_plane(axis, plane, title)
        row[0].set_ylabel(f"{DIRECTIONS[plane[1]]} (m)")
    figure.colorbar(dots, ax=axes, shrink=0.8, pad=0.01, label=_size_label(found, where), extend="max")
    return figure


def _size_label(found: Diagnosis, where: GapAlongPath) -> str:
    noise = float(np.linalg.norm(found.problem.sigma_nT)) / np.sqrt(where.samples)
    return f"size of the gap (nT); noise alone: {noise:.2g}"


def _planes(path_m: Array) -> list[list[int]]:
    """The planes a path is seen in: from above, and from its longer side where its height changes."""
    extent = np.ptp(path_m, axis=0)
    rises = extent[2] > max(LEAST_HEIGHT_M, LEAST_SHARE * extent[:2].max())
    return [[0, 1], [int(extent[1] > extent[0]), 2]] if rises else [[0, 1]]


def _draw_places(axis: Any, where: GapAlongPath, plane: list[int], size: Array, most: float) -> Any:
    """Dots coloured by size (m,), large ones on top."""
    assert where.pos_m is not None
    order = np.argsort(size)
    return axis.scatter(
        *where.pos_m[order][:, plane].T,
        c=size[order],
        s=7,
        cmap="viridis_r",
        vmin=0,
        vmax=most,
        linewidths=0,
        zorder=2,
        rasterized=True,
    )


def _label_plane(axis: Any, plane: list[int], title: str) -> None:
    above = plane == [0, 1]
    axis.set(xlabel=f"{DIRECTIONS[plane[0]]} (m)", title=f"{'From above' if above else 'From the side'}, {title}")
    if above:
        axis.set_aspect("equal")


def draw_spectrum(found: Diagnosis) -> Figure:
    """Power density of the gap before and after, beside the noise that neighbouring samples show."""
    figure = Figure(figsize=(WIDTH_IN, 3.2), layout="constrained")
    axis: Any = figure.subplots()
    interval = found.problem.state.interval_s
    for values, colour, label in _curves(found.before_nT, found.after_nT):
        axis.loglog(*_density(values, interval), color=colour, label=label)
    level = float(np.sqrt((found.problem.sigma_nT**2).mean() * 2 * interval))
    axis.axhline(level, color=SOFT, linestyle="--", label="noise of a sample")
    axis.set(xlabel="frequency (Hz)", ylabel="nT/√Hz")
    axis.legend()
    return figure


def draw_channel(found: Diagnosis) -> Figure:
    """The gap against the channels it goes with most, where it is largest: means as dots, bins as lines."""
    values = dict(channels(found.problem))
    names = [name for name, _, _ in found.where if name in values][:3] or ["time_s"]
    gaps = displayed_gap(found)
    component = int(np.argmax((gaps[0] ** 2).sum(axis=0)))
    length = block_length(len(gaps[0]), MOST_POINTS)
    figure = Figure(figsize=(WIDTH_IN, 3.2), layout="constrained")
    axes = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axis, name in zip(axes, names, strict=True):
        channel = block_means(values[name], length)
        for gap, colour, label in _curves(*gaps):
            thin = block_means(gap[:, component], length, found.problem.usable)
            axis.plot(channel, thin, ".", markersize=2, color=colour, alpha=0.3)
            axis.plot(*_binned(channel, thin), color=colour, linewidth=2.0, label=label)
        axis.set_xlabel(name)
    axes[0].set_ylabel(f"{axes_of(found)[component]} (nT)")
    axes[0].legend()
    return figure


def draw_ranking(found: Diagnosis) -> Figure:
    """Evidence of every candidate in the first round, on a signed log scale of nats."""
    rows = found.ranking[:12][::-1]
    colour = {other: BEFORE for one in found.named for other in one.alternatives}
    colour |= {one.name: AFTER for one in found.named}
    figure = Figure(figsize=(WIDTH_IN, 0.26 * max(len(rows), 2) + 0.9), layout="constrained")
    axis: Any = figure.subplots()
    for y, one in enumerate(rows):
        bar = axis.barh(y, one.nats, color=colour.get(one.name, RAW))
        axis.bar_label(bar, [f"{one.evidence.strength:.2g} sigma"], padding=3, fontsize=8, color=SOFT)
        axis.plot(one.needed, y, "|", color=SOFT, markersize=10)
    axis.set_yticks(range(len(rows)), [one.name for one in rows])
    axis.set_xscale("symlog", linthresh=5)
    axis.margins(x=0.12)
    axis.set_xlabel("evidence on held-out data (nats); the ticks are what is needed")
    return figure


def _curves(before: Array, after: Array) -> list[tuple[Array, str, str]]:
    """What is drawn of a gap: values, colour, label; one curve where they are the same."""
    if np.array_equal(before, after):
        return [(before, BEFORE, "before and after alike")]
    return [(before, BEFORE, "before"), (after, AFTER, "after")]


def _time(found: Diagnosis) -> tuple[Array, str]:
    time_s = found.problem.state.time_s
    scale, unit = (1.0, "s") if time_s[-1] < 600 else (60.0, "min") if time_s[-1] < 3 * 3600 else (3600.0, "h")
    return time_s / scale, unit


def _binned(channel: Array, values: Array) -> tuple[Array, Array]:
    """Means of both over bins of equal count along the channel."""
    known = np.flatnonzero(np.isfinite(values))
    parts = np.array_split(known[np.argsort(channel[known], kind="stable")], BINS)
    return tuple(np.array([of[part].mean() for part in parts if len(part)]) for of in (channel, values))  # type: ignore[return-value]


def _density(values: Array, interval_s: float) -> tuple[Array, Array]:
    n = len(values)
    power = (np.abs(np.fft.rfft(values - values.mean(axis=0), axis=0)) ** 2).mean(axis=1) * 2 * interval_s / n
    f = np.fft.rfftfreq(n, interval_s)
    edges = np.unique(np.geomspace(1, len(f) - 1, 300).astype(int))
    cut = list(itertools.pairwise(edges))
    return np.array([f[a:b].mean() for a, b in cut]), np.sqrt(np.array([power[a:b].mean() for a, b in cut]))
