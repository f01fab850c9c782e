"""Plots of the injected effects: size and course of each contribution."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from reports.palette import XYZ
from reports.plots.style import draw_lines, draw_phase_bands, label_time_axis, panels
from reports.text.outcome import acting_effects, rms_length
from validation.scoring.outcome import Outcome
from validation.text import digits


def draw_effect_sizes(outcome: Outcome) -> Figure:
    """Draw the root mean square of each effect's contribution on a logarithmic scale, in the order of the chain."""
    sizes = {name: rms_length(value) for name, value in outcome.effects.items()}
    drawn = {name: size for name, size in sizes.items() if size > 0}
    figure, axis = panels(0.6 + 0.27 * max(1, len(sizes)))
    floor = 10 ** np.floor(np.log10(min(drawn.values(), default=1.0)) - 0.3)
    for row, size in enumerate(sizes.values()):
        axis.plot([floor, max(size, floor)], [row, row], color=XYZ[0], linewidth=5, solid_capstyle="butt")
        axis.annotate(
            f"{digits(size)} nT", (max(size, floor), row), xytext=(6, 0), textcoords="offset points", va="center"
        )
    axis.set(
        xscale="log", xlabel="rms of the contribution (nT)", yticks=range(len(sizes)), ylim=(len(sizes) - 0.4, -0.6)
    )
    axis.set_xlim(floor, 4 * max(drawn.values(), default=1.0))
    axis.set_yticklabels(list(sizes))
    axis.grid(visible=False, axis="y")
    return figure


def draw_effects(outcome: Outcome) -> Figure:
    """Draw the contribution of each effect over time by component; each panel has a scale of its own."""
    effects = acting_effects(outcome)
    rows = max(1, -(-len(effects) // 2))
    figure, axes = panels(1.45 * rows + 0.5, rows, 2, sharex=True, squeeze=False)
    for axis, (name, value) in zip(axes.flat, effects.items(), strict=False):
        draw_lines(axis, outcome, value, XYZ, alpha=0.7)
        axis.set_title(f"{name}    rms {digits(rms_length(value))} nT")
        axis.set_ylabel("nT")
        draw_phase_bands([axis], outcome, labelled=False)
    for axis in axes.flat[len(effects) :]:
        axis.set_visible(False)
    for axis in axes.flat[max(0, len(effects) - 2) : len(effects)]:
        label_time_axis(axis, outcome)
        axis.tick_params(labelbottom=True)
    handles = [axes[0, 0].plot([], [], color=colour)[0] for colour in XYZ]
    figure.legend(handles, ["x forward", "y left", "z up"], loc="outside lower center", ncols=3)
    return figure
