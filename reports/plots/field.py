"""Plots of the field: on the sphere, strength over time, and error after correction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from reports.palette import INK, LINES, RAW, XYZ
from reports.plots.style import (
    WIDTH_IN,
    clip_outliers,
    draw_lines,
    draw_phase_bands,
    label_time_axis,
    legend_at_right,
    panels,
)
from reports.text.outcome import rms_length
from scenarios.arrays import Array
from validation.scoring.outcome import Outcome
from validation.signals.thinning import every_nth
from validation.text import digits

MOST_POINTS = 4000
MOST_LINES = len(LINES)
PLANES = ((0, 1), (0, 2), (1, 2))
SCALED_BY = 3
"""Number of the best calibrators that set the scale of the error axis."""
DASHED = (0, (4, 3))


def draw_sphere(outcome: Outcome) -> Figure:
    """Draw the raw field and the best corrected field with the reference sphere, in space and in three projections."""
    best = {f"corrected: {name}": outcome.corrected[name] for name in outcome.shown()[:1]}
    return draw_clouds({"raw": outcome.recording.mag_nT} | best, outcome.field_strength_nT)


def draw_clouds(clouds: Mapping[str, Array], field_strength_nT: float) -> Figure:
    """Draw fields (n, 3) in nT, by title, with the reference sphere, in space and in three projections."""
    figure = Figure(figsize=(WIDTH_IN, 3.0 * len(clouds)), layout="constrained")
    parts = figure.subfigures(len(clouds), 1, squeeze=False)[:, 0]
    for part, (title, cloud) in zip(parts, clouds.items(), strict=True):
        _sphere_row(part, title, cloud[every_nth(len(cloud), MOST_POINTS)] / 1e3, field_strength_nT / 1e3)
    return figure


def _sphere_row(part: Any, title: str, cloud_uT: Array, radius_uT: float) -> None:
    """Draw a field (n, 3) in space and in three projections, coloured by the distance from the sphere."""
    part.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=9.5)
    grid = part.add_gridspec(1, 4, width_ratios=(1.3, 1, 1, 1))
    dots = _dots((np.linalg.norm(cloud_uT, axis=1) - radius_uT) * 1e3)
    reach = 1.05 * max(radius_uT, float(np.nanmax(np.abs(cloud_uT), initial=0.0)))
    space: Any = part.add_subplot(grid[0], projection="3d")
    _wire_sphere(space, radius_uT, reach)
    shown = space.scatter(*cloud_uT.T, depthshade=False, **dots)
    for k, plane in enumerate(PLANES):
        axis = part.add_subplot(grid[k + 1])
        axis.add_patch(Circle((0, 0), radius_uT, fill=False, color=INK, linewidth=0.8, linestyle=DASHED))
        axis.scatter(*cloud_uT[:, plane].T, **dots)
        _frame_plane(axis, plane, reach)
    part.colorbar(shown, ax=part.axes, shrink=0.8, pad=0.01, label="strength − reference (nT)", extend="both")


def _frame_plane(axis: Any, plane: tuple[int, int], reach: float) -> None:
    x, y = ("xyz"[k] for k in plane)
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xlabel=f"{x} (µT)", ylabel=f"{y} (µT)")


def _dots(error_nT: Array) -> dict[str, Any]:
    """Return the style of points coloured by their error (n,); the largest 1 % lie beyond the colour scale."""
    finite = error_nT[np.isfinite(error_nT)]
    limit = float(np.quantile(np.abs(finite), 0.99)) if finite.size else 1.0
    colour = {"c": error_nT, "cmap": "PuOr_r", "vmin": -limit, "vmax": limit}
    return {**colour, "s": 5, "linewidths": 0, "rasterized": True}


def _wire_sphere(axis: Any, radius: float, reach: float) -> None:
    longitude, latitude = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(-np.pi / 2, np.pi / 2, 13))
    x, y = np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude)
    axis.plot_wireframe(radius * x, radius * y, radius * np.sin(latitude), color=RAW, linewidth=0.3, alpha=0.7)
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axis.set_box_aspect((1, 1, 1), zoom=0.85)
    axis.set(xlabel="x (µT)", ylabel="y (µT)", zlabel="z (µT)")
    axis.tick_params(labelsize=7, pad=-2)
    axis.locator_params(nbins=4, prune="both")  # ticks of two axes meet at a corner
    for side in (axis.xaxis, axis.yaxis, axis.zaxis):
        side.labelpad = -7


def draw_norm(outcome: Outcome) -> Figure:
    """Draw the field strength over time: raw, true and corrected above; corrected minus true below."""
    strengths = {name: _strength(outcome.corrected[name]) for name in outcome.shown()[:MOST_LINES]}
    figure, (whole, zoom) = panels(4.6, 2, sharex=True)
    axes = [whole, zoom]
    _draw_strengths(whole, outcome, strengths)
    _draw_errors(zoom, outcome, strengths)
    legend_at_right(whole)
    draw_phase_bands(axes, outcome)
    label_time_axis(zoom, outcome)
    return figure


def _draw_strengths(axis: Any, outcome: Outcome, strengths: dict[str, Array]) -> None:
    """Draw raw, corrected and true strength."""
    draw_lines(axis, outcome, _strength(outcome.recording.mag_nT), (RAW,), labels=("raw",))
    for (name, strength_nT), colour in reversed(list(zip(strengths.items(), LINES, strict=False))):
        draw_lines(axis, outcome, strength_nT, (colour,), labels=(name,), alpha=0.8)
    draw_lines(axis, outcome, _strength(outcome.truth.field_nT), (INK,), labels=("truth",), linestyle=(0, (5, 3)))
    axis.set_ylabel("field strength (nT)")


def _draw_errors(axis: Any, outcome: Outcome, strengths: dict[str, Array]) -> None:
    """Draw corrected minus true strength on the scale of the best calibrators."""
    truth_nT = _strength(outcome.truth.field_nT)
    errors = {name: strength_nT - truth_nT for name, strength_nT in strengths.items()}
    for (name, error_nT), colour in reversed(list(zip(errors.items(), LINES, strict=False))):
        draw_lines(axis, outcome, error_nT, (colour,), labels=(name,), alpha=0.8)
    clip_outliers(axis, np.concatenate(list(errors.values())[:SCALED_BY] or [truth_nT]))
    axis.axhline(0, color=INK, linewidth=0.8, linestyle=(0, (5, 3)))
    axis.set_ylabel("corrected − truth (nT)")


def _strength(field_nT: Array) -> Array:
    return np.asarray(np.linalg.norm(field_nT, axis=1))


def draw_residuals(outcome: Outcome) -> Figure:
    """Draw corrected field minus truth by component, a row with a scale of its own per calibrator."""
    names = outcome.shown()
    rows = max(1, len(names))
    figure, axes = panels(1.35 * rows + 0.5, rows, sharex=True, squeeze=False)
    axes = axes[:, 0]
    for axis, name in zip(axes, names, strict=False):
        residual_nT = outcome.residual_nT(name)
        mark = "†" if outcome.rotation_removed(name) else ""
        draw_lines(axis, outcome, residual_nT, XYZ, alpha=0.7)
        components = ",  ".join(f"{c} {digits(rms_length(residual_nT[:, k]))}" for k, c in enumerate("xyz"))
        title = f"{name}{mark}    rms {digits(rms_length(residual_nT))} nT   ({components})"
        axis.set_title(title, pad=15 if axis is axes[0] else 4)
        axis.axhline(0, color=INK, linewidth=0.6)
        clip_outliers(axis, residual_nT)
        axis.set_ylabel("nT")
    draw_phase_bands(list(axes), outcome)
    label_time_axis(axes[-1], outcome)
    handles = [axes[0].plot([], [], color=colour)[0] for colour in XYZ]
    figure.legend(handles, ["x forward", "y left", "z up"], loc="outside lower center", ncols=3)
    return figure
