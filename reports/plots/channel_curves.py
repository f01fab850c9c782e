"""Plots of fitted curves of channels (effect `channel_effect`)."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.palette import RAW, XYZ
from reports.plots.style import panels
from reports.presentation.diagnosis import PresentedDiagnosis


def draw_curves(found: PresentedDiagnosis) -> Figure:
    """Draw each curve with its 95 % band against the channel, a panel per sensor axis; dots: gap without the curve."""
    figure, rows = panels(2.6 * len(found.curves) + 0.3, len(found.curves), 3, sharey="row", squeeze=False)
    for row, one in zip(rows, found.curves, strict=True):
        for axis, name, colour, curve, half, k in zip(
            row, "xyz", XYZ, one.curve_nT.T, one.half_nT.T, range(3), strict=True
        ):
            if one.dots is not None:
                axis.plot(one.dots[0], one.dots[1][:, k], ".", markersize=2, color=RAW, alpha=0.4, zorder=1)
            axis.fill_between(one.channel, curve - half, curve + half, color=colour, alpha=0.3, linewidth=0)
            axis.plot(one.channel, curve, color=colour, linewidth=2.0, zorder=2)
            axis.set(xlabel=one.label, title=name)
        row[0].set_ylabel("nT")
    return figure
