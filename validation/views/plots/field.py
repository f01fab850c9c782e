"""Pictures of the field: on the sphere, its strength, and what is left after correction."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from validation.scoring.outcome import Array, Outcome
from validation.signals.thin import every_nth
from validation.text import digits
from validation.views.palette import INK, LINES, RAW, XYZ
from validation.views.plots.style import WIDTH_IN, keep_readable, lines, phase_bands, time_axis
from validation.views.words.outcome import rms_length

MOST_POINTS = 4000
MOST_LINES = len(LINES)
PLANES = ((0, 1), (0, 2), (1, 2))


def draw_sphere(outcome: Outcome) -> Figure:
    """Raw field and best corrected field against the reference sphere, in space and in three projections."""
    clouds = [
        ("raw", outcome.recording.mag_nT),
        *((f"corrected: {n}", outcome.corrected[n]) for n in outcome.shown()[:1]),
    ]
    figure = Figure(figsize=(WIDTH_IN, 3.0 * len(clouds)), layout="constrained")
    parts = figure.subfigures(len(clouds), 1, squeeze=False)[:, 0]
    for part, (title, cloud) in zip(parts, clouds, strict=True):
        _sphere_row(part, title, cloud[every_nth(len(cloud), MOST_POINTS)] / 1e3, outcome.field_strength_nT / 1e3)
    return figure


def _sphere_row(part: Any, title: str, cloud_uT: Array, radius_uT: float) -> None:
    error_nT = (np.linalg.norm(cloud_uT, axis=1) - radius_uT) * 1e3
    finite = error_nT[np.isfinite(error_nT)]
    limit = float(np.quantile(np.abs(finite), 0.99)) if finite.size else 1.0
    dots: dict[str, Any] = {
        "c": error_nT, "cmap": "PuOr_r", "vmin": -limit, "vmax": limit, "s": 5, "linewidths": 0, "rasterized": True,
    }  # fmt: skip
    part.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=9.5)
    grid = part.add_gridspec(1, 4, width_ratios=(1.3, 1, 1, 1))
    space: Any = part.add_subplot(grid[0], projection="3d")
    reach = 1.05 * max(radius_uT, float(np.nanmax(np.abs(cloud_uT), initial=0.0)))
    _wire_sphere(space, radius_uT, reach)
    shown = space.scatter(*cloud_uT.T, depthshade=False, **dots)
    for k, (i, j) in enumerate(PLANES):
        axis = part.add_subplot(grid[k + 1])
        axis.add_patch(Circle((0, 0), radius_uT, fill=False, color=INK, linewidth=0.8, linestyle=(0, (4, 3))))
        axis.scatter(cloud_uT[:, i], cloud_uT[:, j], **dots)
        axis.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axis.set(xlabel=f"{'xyz'[i]} (µT)", ylabel=f"{'xyz'[j]} (µT)")
    part.colorbar(shown, ax=part.axes, shrink=0.8, pad=0.01, label="strength − reference (nT)", extend="both")


def _wire_sphere(axis: Any, radius: float, reach: float) -> None:
    longitude, latitude = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(-np.pi / 2, np.pi / 2, 13))
    x, y = np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude)
    axis.plot_wireframe(radius * x, radius * y, radius * np.sin(latitude), color=RAW, linewidth=0.3, alpha=0.7)
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axis.set_box_aspect((1, 1, 1), zoom=0.85)
    axis.set(xlabel="x (µT)", ylabel="y (µT)", zlabel="z (µT)")
    axis.tick_params(labelsize=7, pad=-2)
    axis.locator_params(nbins=4)
    for side in (axis.xaxis, axis.yaxis, axis.zaxis):
        side.labelpad = -7


def draw_norm(outcome: Outcome) -> Figure:
    """Field strength over time: raw, truth and corrected above; corrected minus truth below."""
    names = outcome.shown()[:MOST_LINES]
    truth_nT = np.linalg.norm(outcome.truth.field_nT, axis=1)
    figure = Figure(figsize=(WIDTH_IN, 4.6), layout="constrained")
    whole, zoom = axes = figure.subplots(2, 1, sharex=True)
    lines(whole, outcome, np.linalg.norm(outcome.recording.mag_nT, axis=1), (RAW,), labels=("raw",))
    for name, colour in reversed(list(zip(names, LINES, strict=False))):
        norm_nT = np.linalg.norm(outcome.corrected[name], axis=1)
        lines(whole, outcome, norm_nT, (colour,), alpha=0.8)
        lines(zoom, outcome, norm_nT - truth_nT, (colour,), labels=(name,), alpha=0.8)
    lines(whole, outcome, truth_nT, (INK,), labels=("truth",), linestyle=(0, (5, 3)))
    keep_readable(
        zoom, np.concatenate([np.linalg.norm(outcome.corrected[n], axis=1) - truth_nT for n in names[:3]] or [truth_nT])
    )
    zoom.axhline(0, color=INK, linewidth=0.8, linestyle=(0, (5, 3)))
    whole.set_ylabel("field strength (nT)")
    zoom.set_ylabel("corrected − truth (nT)")
    for axis in axes if names else [whole]:
        axis.legend(reverse=axis is zoom, loc="center left", bbox_to_anchor=(1.0, 0.5))
    phase_bands(list(axes), outcome)
    time_axis(zoom, outcome)
    return figure


def draw_residuals(outcome: Outcome) -> Figure:
    """Corrected field minus truth, component by component, one row a calibrator; each row has its own scale."""
    names = outcome.shown()
    figure = Figure(figsize=(WIDTH_IN, 1.35 * max(1, len(names)) + 0.5), layout="constrained")
    axes = np.atleast_1d(figure.subplots(max(1, len(names)), 1, sharex=True))
    for axis, name in zip(axes, names, strict=False):
        residual_nT = outcome.residual_nT(name)
        mark = "†" if outcome.rotation_removed(name) else ""
        lines(axis, outcome, residual_nT, XYZ, alpha=0.7)
        each = ",  ".join(f"{c} {digits(rms_length(residual_nT[:, k]))}" for k, c in enumerate("xyz"))
        title = f"{name}{mark}    rms {digits(rms_length(residual_nT))} nT   ({each})"
        axis.set_title(title, pad=15 if axis is axes[0] else 4)
        axis.axhline(0, color=INK, linewidth=0.6)
        keep_readable(axis, residual_nT)
        axis.set_ylabel("nT")
    phase_bands(list(axes), outcome)
    time_axis(axes[-1], outcome)
    handles = [axes[0].plot([], [], color=colour)[0] for colour in XYZ]
    figure.legend(handles, ["x forward", "y left", "z up"], loc="outside lower center", ncols=3)
    return figure
