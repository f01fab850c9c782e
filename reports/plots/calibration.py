"""Plots of a calibration: strength before and after, and the directions that the motion has shown."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from reports.palette import INK, LINES, RAW
from reports.plots.style import clip_outliers, legend_at_right, panels, time_scale
from scenarios.arrays import Array
from validation.signals.thinning import envelope


def draw_strength_before_after(
    time_s: Array, raw_nT: Array, corrected_nT: Array, strength_nT: float, reference: str = "the Earth's field"
) -> Figure:
    """Draw the strength of the raw and of the corrected field (n, 3) over time, the corrected one also by itself.

    reference : what has `strength_nT`, in words.
    """
    figure, (both, after) = panels(4.8, 2, sharex=True)
    span, unit = time_scale(time_s)
    sizes = np.column_stack([np.linalg.norm(raw_nT, axis=1), np.linalg.norm(corrected_nT, axis=1)])
    time, thin = envelope(time_s / span, sizes)
    both.plot(time, thin[:, 0] / 1e3, color=RAW, label="raw")
    both.plot(time, thin[:, 1] / 1e3, color=LINES[0], label="corrected")
    both.axhline(strength_nT / 1e3, color=INK, linewidth=0.7, linestyle="--", label=reference)
    both.set_ylabel("µT")
    both.set_title("strength")
    legend_at_right(both)
    after.plot(time, thin[:, 1] - strength_nT, color=LINES[0], label="corrected")
    after.axhline(0.0, color=INK, linewidth=0.7, linestyle="--")
    after.set_ylabel("nT")
    after.set_title(f"corrected strength minus {reference}")
    clip_outliers(after, thin[:, 1] - strength_nT)
    after.set_xlabel(f"time ({unit})")
    return figure
