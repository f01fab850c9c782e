"""Plots of a pooled diagnosis: each effect's coefficients by recording, and gaps before and after."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from diagnosis.several.pooled_effect import Presence
from reports.palette import LINES, RAW, SOFT
from reports.plots.diagnosis import BOTH, draw_output, thinned
from reports.plots.style import panels
from reports.presentation.pooled import CoefficientPanel, PresentedEffect, PresentedPool

MOST_COLUMNS = 3
"""Largest number of panels in a row."""


def draw_coefficients(pooled: PresentedPool, effect: PresentedEffect) -> Figure:
    """Draw every component of an effect's parameters by recording with 95 % interval; band: the pooled interval."""
    columns = min(len(effect.panels), MOST_COLUMNS)
    rows = -(-len(effect.panels) // columns)
    height = 0.3 * len(pooled.names) + 1.1
    figure, axes = panels(rows * height + 0.3, rows, columns, squeeze=False, sharey=True)
    for axis in axes.ravel()[len(effect.panels) :]:
        axis.set_visible(False)
    for axis, panel in zip(axes.ravel(), effect.panels, strict=False):
        _draw_panel(axis, panel, effect.presence)
    for axis in axes[:, 0]:
        axis.set_yticks(range(len(pooled.names)), pooled.names)
        axis.set_ylim(len(pooled.names) - 0.4, -0.6)
    return figure


def _draw_panel(axis: Any, panel: CoefficientPanel, presence: tuple[Presence, ...]) -> None:
    value, low, high = panel.pooled
    axis.axvspan(low, high, color=LINES[0], alpha=0.15, linewidth=0)
    axis.axvline(value, color=LINES[0], linewidth=1.0)
    axis.axvline(0.0, color=SOFT, linewidth=0.7, linestyle=":")
    axis.set_xlabel(panel.label)
    for row, (own, finding) in enumerate(zip(panel.each, presence, strict=True)):
        if own is not None:
            v, a, b = own
            colour = {Presence.PRESENT: LINES[0], Presence.ABSENT: LINES[1]}.get(finding, RAW)
            axis.errorbar(v, row, xerr=[[v - a], [b - v]], fmt="o", color=colour, markersize=4, capsize=3)


def draw_gaps(pooled: PresentedPool) -> Figure:
    """Draw measured minus simulated over time, a row per recording: before, and after with the others' coefficients."""
    figure, axes = panels(1.6 * len(pooled.names) + 0.8, len(pooled.names), squeeze=False)
    axes = axes[:, 0]
    for axis, name, gap in zip(axes, pooled.names, pooled.series, strict=True):
        draw_output(axis, thinned(gap), gap.largest, BOTH)
        axis.set_ylabel(f"{'xyz'[gap.largest] if gap.before_nT.shape[1] == 3 else 'strength'} (nT)")
        axis.set_title(name)
        axis.set_xlim(gap.time_s[0], gap.time_s[-1])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    axes[-1].set_xlabel("time (s)")
    return figure
