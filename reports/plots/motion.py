"""Plots of the motion: path, attitude, temperature, motor currents."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from reports.palette import LINES, XYZ, phase_colours
from reports.plots.style import WIDTH_IN, draw_lines, draw_phase_bands, label_time_axis, panels, time_scale
from scenarios.arrays import Array
from validation.scoring.outcome import Outcome
from validation.signals.quaternion_conventions import euler_deg
from validation.signals.thinning import every_nth

STRETCH = 4.0
"""A path longer than this many times its width is drawn with unequal axes."""


@dataclass(frozen=True)
class _Row:
    """Quantity over time: axis label, values (n,) or (n, k), colours, and names of the k series."""

    label: str
    values: Array
    colours: tuple[str, ...]
    names: tuple[str, ...] = ()


def draw_path(outcome: Outcome) -> Figure:
    """Draw the true path in space, from above, and as height over time, coloured by phase."""
    figure = Figure(figsize=(WIDTH_IN, 4.4), layout="constrained")
    grid = figure.add_gridspec(1, 3, width_ratios=(1.45, 1, 1))
    space: Any = figure.add_subplot(grid[0], projection="3d")
    above, height = figure.add_subplot(grid[1]), figure.add_subplot(grid[2])
    _draw_phases(outcome, space, above, height)
    _frame_space(space, outcome.truth.pos_enu_m)
    above.set(xlabel="east (m)", ylabel="north (m)", title="From above", aspect="equal", adjustable="datalim")
    height.set(ylabel="up (m)", title="Height")
    label_time_axis(height, outcome)
    handles, labels = space.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _draw_phases(outcome: Outcome, space: Any, above: Any, height: Any) -> None:
    """Draw the path on three axes, a colour per phase; each label is named once."""
    scale, _ = time_scale(outcome.recording.time_s)
    colours, named = phase_colours(outcome), set[str]()
    for label, first, last in outcome.phases():
        part = every_nth(last - first, 3000)
        xyz = outcome.truth.pos_enu_m[first : last + 1][part]
        time = outcome.recording.time_s[first : last + 1][part] / scale
        space.plot(*xyz.T, color=colours[label], label=None if label in named else label)
        above.plot(xyz[:, 0], xyz[:, 1], color=colours[label])
        height.plot(time, xyz[:, 2], color=colours[label])
        named.add(label)


def _frame_space(axis: Any, pos_m: Array) -> None:
    extent = np.maximum(np.nanmax(pos_m, axis=0) - np.nanmin(pos_m, axis=0), 1e-3)
    box = np.maximum(extent, extent.max() / STRETCH)
    axis.set_box_aspect(tuple(box), zoom=0.8)
    centre = (np.nanmax(pos_m, axis=0) + np.nanmin(pos_m, axis=0)) / 2
    half = np.maximum(extent, 0.5) / 2
    for set_limits, c, h in zip((axis.set_xlim, axis.set_ylim, axis.set_zlim), centre, half, strict=True):
        set_limits(c - h, c + h)
    stretched = "" if np.allclose(box, extent) else " (axes not to one scale)"
    axis.set(xlabel="east (m)", ylabel="north (m)", zlabel="up (m)", title=f"In space{stretched}")
    axis.tick_params(labelsize=7.5, pad=0)
    axis.locator_params(nbins=4)


def draw_vehicle(outcome: Outcome) -> Figure:
    """Draw attitude, temperature and motor currents over time, as far as recorded."""
    rows = _vehicle_rows(outcome)
    figure, axes = panels(1.55 * len(rows) + 0.4, len(rows), 1, sharex=True)
    for axis, row in zip(axes, rows, strict=True):
        draw_lines(axis, outcome, row.values, row.colours, **({"labels": row.names} if row.names else {}))
        axis.set_ylabel(row.label)
        if row.names:
            axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), ncols=1 + (len(row.names) > 6))
    draw_phase_bands(list(axes), outcome)
    label_time_axis(axes[-1], outcome)
    return figure


def _vehicle_rows(outcome: Outcome) -> list[_Row]:
    """Return the recorded quantities of the vehicle, a row each."""
    recording, (yaw, pitch, roll) = outcome.recording, euler_deg(outcome.truth.q).T
    yaw, roll = (np.unwrap(angle, period=360) for angle in (yaw, roll))
    rows = [
        _Row("yaw, unwrapped (°)", yaw, XYZ[:1]),
        _Row("pitch, roll (°)", np.column_stack([pitch, roll]), XYZ[1:], ("pitch", "roll")),
    ]
    if recording.temperature_degC is not None:
        rows.append(_Row("temperature (°C)", recording.temperature_degC, XYZ[1:2]))
    if recording.current_A is not None and recording.current_A.size:
        motors = tuple(f"motor {k}" for k in recording.motors)
        rows.append(_Row("motor current (A)", recording.current_A, LINES, motors))
    return rows
