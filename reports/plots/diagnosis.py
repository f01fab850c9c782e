"""Plots of a diagnosis: gap before and after over time, along the path, by frequency and by channel; evidence."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from diagnosis.evidence.localise import channels
from diagnosis.result import Diagnosis
from reports.gap_series import (
    GapAlongPath,
    block_length,
    block_means,
    displayed_gap,
    gap_along_path,
    hidden_by_iron_refit,
    relative_to_first,
)
from reports.palette import AFTER, BEFORE, RAW, SOFT
from reports.plots.style import WIDTH_IN, clip_outliers, panels, time_scale
from scenarios.arrays import Array
from validation.signals.thinning import every_nth

FINE, COARSE, MOST_POINTS = 1500, 200, 4000
"""Points of the pale and of the bold lines over time, and of a cloud."""
LEAST_HEIGHT_M, LEAST_SHARE = 0.5, 0.02
"""A path's height is drawn from this extent on, and from this share of the horizontal one."""
BINS = 24
DIRECTIONS = ("east", "north", "up")


def draw_gap(diagnosis: Diagnosis) -> Figure:
    """Draw measured minus simulated over time, before and after: means over short (pale) and long (bold) blocks."""
    labels = diagnosis.problem.outputs
    figure = Figure(figsize=(WIDTH_IN, 1.7 * len(labels) + 0.8), layout="constrained")
    axes = figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0]
    scale, unit = time_scale(diagnosis.problem.state.time_s)
    time = diagnosis.problem.state.time_s / scale
    for (gap, colour, label), (i, axis) in itertools.product(_curves(*displayed_gap(diagnosis)), enumerate(axes)):
        draw_block_means(axis, time, gap[:, i], diagnosis.problem.usable, colour, label)
    least = block_means(diagnosis.before_nT, block_length(len(time), FINE), diagnosis.problem.usable)
    for i, axis in enumerate(axes):
        clip_outliers(axis, least[:, i])
        axis.set_ylabel(f"{labels[i]} (nT)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    how = "models without refit" if hidden_by_iron_refit(diagnosis) else "iron refitted"
    axes[0].set_title(f"Measured minus simulated, {how}")
    axes[-1].set(xlabel=f"time ({unit})", xlim=(time[0], time[-1]))
    return figure


def draw_block_means(axis: Any, time: Array, gap: Array, usable: Array, colour: str, label: str) -> None:
    """Draw a gap (n,) over time as means over short (pale) and long (bold) blocks."""
    for most, style in ((FINE, {"alpha": 0.3}), (COARSE, {"linewidth": 1.6, "label": label})):
        length = block_length(len(gap), most)
        axis.plot(block_means(time, length), block_means(gap, length, usable), color=colour, **style)


def draw_map(diagnosis: Diagnosis) -> Figure:
    """Draw the size of the gap along the path, before and after: from above, and from the side if height changes."""
    where, position = gap_along_path(diagnosis), diagnosis.problem.recording.pos_enu_m
    assert position is not None
    path_m = relative_to_first(position)[every_nth(len(position), MOST_POINTS)]
    planes = _planes(path_m)
    figure, axes = panels(3.6 * len(planes) + 0.2, len(planes), 2, sharex="row", sharey="row", squeeze=False)
    sizes = [np.linalg.norm(gap, axis=1) for gap in (where.before_nT, where.after_nT)]
    most = max(float(np.nanquantile(sizes[0], 0.98)), 1e-9)
    for plane, row in zip(planes, axes, strict=True):
        for axis, size, title in zip(row, sizes, ("before", "after"), strict=True):
            axis.plot(*path_m[:, plane].T, color=RAW, linewidth=0.4, zorder=1)
            dots = _draw_places(axis, where, plane, size, most)
            _label_plane(axis, plane, title)
        row[0].set_ylabel(f"{DIRECTIONS[plane[1]]} (m)")
    figure.colorbar(dots, ax=axes, shrink=0.8, pad=0.01, label=_size_label(diagnosis, where), extend="max")
    return figure


def _size_label(diagnosis: Diagnosis, where: GapAlongPath) -> str:
    noise = float(np.linalg.norm(diagnosis.problem.sigma_nT)) / np.sqrt(where.samples)
    return f"size of the gap (nT); noise alone: {noise:.2g}"


def _planes(path_m: Array) -> list[list[int]]:
    """Return the planes of view: from above, and from the path's longer side where the height changes."""
    extent = np.ptp(path_m, axis=0)
    rises = extent[2] > max(LEAST_HEIGHT_M, LEAST_SHARE * extent[:2].max())
    return [[0, 1], [int(extent[1] > extent[0]), 2]] if rises else [[0, 1]]


def _draw_places(axis: Any, where: GapAlongPath, plane: list[int], size: Array, most: float) -> Any:
    """Draw dots coloured by size (m,), large values on top."""
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


def draw_spectrum(diagnosis: Diagnosis) -> Figure:
    """Draw the amplitude density of the gap before and after, with the white noise of a sample."""
    figure, axis = panels(3.2)
    interval = diagnosis.problem.state.interval_s
    for values, colour, label in _curves(diagnosis.before_nT, diagnosis.after_nT):
        axis.loglog(*_density(values, interval), color=colour, label=label)
    level = float(np.sqrt((diagnosis.problem.sigma_nT**2).mean() * 2 * interval))
    axis.axhline(level, color=SOFT, linestyle="--", label="noise of a sample")
    axis.set(xlabel="frequency (Hz)", ylabel="nT/√Hz")
    axis.legend()
    return figure


def draw_channel(diagnosis: Diagnosis) -> Figure:
    """Draw the largest component of the gap against the channels that the gap follows: means as dots, bins as lines."""
    values = dict(channels(diagnosis.problem))
    names = [name for name, _, _ in diagnosis.where if name in values][:3] or ["time_s"]
    gaps = displayed_gap(diagnosis)
    component = int(np.argmax((gaps[0] ** 2).sum(axis=0)))
    length = block_length(len(gaps[0]), MOST_POINTS)
    figure = Figure(figsize=(WIDTH_IN, 3.2), layout="constrained")
    axes = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axis, name in zip(axes, names, strict=True):
        channel = block_means(values[name], length)
        for gap, colour, label in _curves(*gaps):
            thin = block_means(gap[:, component], length, diagnosis.problem.usable)
            axis.plot(channel, thin, ".", markersize=2, color=colour, alpha=0.3)
            axis.plot(*_binned(channel, thin), color=colour, linewidth=2.0, label=label)
        axis.set_xlabel(name)
    axes[0].set_ylabel(f"{diagnosis.problem.outputs[component]} (nT)")
    axes[0].legend()
    return figure


def draw_ranking(diagnosis: Diagnosis) -> Figure:
    """Draw the evidence of every candidate in the first round, in nats on a signed logarithmic scale."""
    rows = diagnosis.ranking[:12][::-1]
    colour = {other: BEFORE for one in diagnosis.named for other in one.alternatives}
    colour |= {one.name: AFTER for one in diagnosis.named}
    figure, axis = panels(0.26 * max(len(rows), 2) + 0.9)
    for y, one in enumerate(rows):
        bar = axis.barh(y, one.nats, color=colour.get(one.name, RAW))
        axis.bar_label(bar, [f"{one.evidence.strength:.2g} sigma"], padding=3, fontsize=8, color=SOFT)
        axis.plot(one.needed, y, "|", color=SOFT, markersize=10)
    axis.set_yticks(range(len(rows)), [one.name for one in rows])
    axis.set_xscale("symlog", linthresh=5)
    axis.margins(x=0.12)
    axis.set_xlabel("evidence on held-out data (nats); tick: evidence needed")
    return figure


def _curves(before: Array, after: Array) -> list[tuple[Array, str, str]]:
    """Return values, colour and label of the gap before and after; a single curve where the gaps are equal."""
    if np.array_equal(before, after):
        return [(before, BEFORE, "before and after, equal")]
    return [(before, BEFORE, "before"), (after, AFTER, "after")]


def _binned(channel: Array, values: Array) -> tuple[Array, Array]:
    """Return the means of channel and values over bins of equal count along the channel."""
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
