"""Plots of a pooled diagnosis: each effect's coefficients by recording, and gaps before and after."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from diagnosis.result import NamedEffect, parameters
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.transfer import Presence
from reports.palette import AFTER, BEFORE, LINES, RAW, SOFT
from reports.plots.diagnosis import draw_block_means
from reports.plots.style import WIDTH_IN, panels
from validation.text import symbol

MOST_COLUMNS = 3
"""Largest number of panels in a row."""


def draw_coefficients(pooled: PooledDiagnosis, one: CommonEffect) -> Figure:
    """Draw every component of an effect's parameters by recording with 95 % interval; band: the pooled interval."""
    components = _panels(one)
    columns = min(len(components), MOST_COLUMNS)
    rows = -(-len(components) // columns)
    height = 0.3 * len(pooled.names) + 1.1
    figure, axes = panels(rows * height + 0.3, rows, columns, squeeze=False, sharey=True)
    for axis in axes.ravel()[len(components) :]:
        axis.set_visible(False)
    for axis, (name, index, label) in zip(axes.ravel(), components, strict=False):
        _draw_component(axis, pooled, one, name, index)
        axis.set_xlabel(label)
    for axis in axes[:, 0]:
        axis.set_yticks(range(len(pooled.names)), pooled.names)
        axis.set_ylim(len(pooled.names) - 0.4, -0.6)
    return figure


def _panels(one: CommonEffect) -> list[tuple[str, int, str]]:
    """Return parameter, component and label of each panel: fitted parameters, or all numbers where none was fitted."""
    known = parameters(one.named)
    fitted = [name for name, p in known.items() if p["low"] is not None]
    names = fitted or [name for name, p in known.items() if not isinstance(p["value"], str)]
    components = []
    for name in names:
        size = np.size(known[name]["value"])
        unit = symbol(known[name]["unit"])
        parts = _parts(name, size)
        components += [(name, i, f"{name} {part} ({unit})".replace(" ()", "")) for i, part in enumerate(parts)]
    return components


def _parts(name: str, size: int) -> tuple[str, ...]:
    axes = ("east", "north", "up") if "enu" in name else ("x", "y", "z")
    if size == 1:
        return ("",)
    return axes if size == 3 else tuple(a + b for a in "xyz" for b in "xyz")


def _component(one: NamedEffect, name: str, index: int) -> tuple[float, float, float]:
    """Return value and interval of a component; without an interval, the value three times."""
    p = parameters(one)[name]
    value = float(np.ravel(p["value"])[index])
    if p["low"] is None:
        return value, value, value
    return value, float(np.ravel(p["low"])[index]), float(np.ravel(p["high"])[index])


def _draw_component(axis: Any, pooled: PooledDiagnosis, one: CommonEffect, name: str, index: int) -> None:
    value, low, high = _component(one.named, name, index)
    axis.axvspan(low, high, color=LINES[0], alpha=0.15, linewidth=0)
    axis.axvline(value, color=LINES[0], linewidth=1.0)
    axis.axvline(0.0, color=SOFT, linewidth=0.7, linestyle=":")
    for row, (own, finding) in enumerate(zip(one.each, one.presence, strict=True)):
        if own is None:
            continue
        v, a, b = _component(own, name, index)
        colour = {Presence.PRESENT: LINES[0], Presence.ABSENT: LINES[1]}.get(finding, RAW)
        axis.errorbar(v, row, xerr=[[v - a], [b - v]], fmt="o", color=colour, markersize=4, capsize=3)


def draw_gaps(pooled: PooledDiagnosis) -> Figure:
    """Draw measured minus simulated over time, a row per recording: before, and after with the others' coefficients."""
    figure = Figure(figsize=(WIDTH_IN, 1.6 * len(pooled.names) + 0.8), layout="constrained")
    axes = figure.subplots(len(pooled.names), 1, squeeze=False)[:, 0]
    for axis, name, own, before, after in zip(
        axes, pooled.names, pooled.each, pooled.before_nT, pooled.after_nT, strict=True
    ):
        component = int(np.argmax((before**2).sum(axis=0)))
        time_s = own.problem.state.time_s
        for gap, colour, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
            draw_block_means(axis, time_s, gap[:, component], own.problem.usable, colour, label)
        axis.set_ylabel(f"{'xyz'[component] if before.shape[1] == 3 else 'strength'} (nT)")
        axis.set_title(name)
        axis.set_xlim(time_s[0], time_s[-1])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    axes[-1].set_xlabel("time (s)")
    return figure
