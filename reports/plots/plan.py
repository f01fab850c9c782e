"""Pictures of a plan: attitudes over time, and the directions of the field that they show the sensor."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from reports.palette import LINES, RAW, XYZ
from reports.plots.style import WIDTH_IN
from scenarios.arrays import Array
from validation.bound.limit import Limit
from validation.planning.next_leg import LegSequence
from validation.planning.plan import Plan
from validation.text import symbol

STEPS = 1500
"""Points of a line over the whole motion."""
AREA = 1500.0
"""Of all dots together, in points squared."""
VISIBLE = 1e-4
"""Weight of a design's attitude that is drawn."""


def draw_angles(found: Plan) -> Figure:
    """Yaw, pitch and roll over time, a panel each."""
    figure = Figure(figsize=(WIDTH_IN, 5.0), layout="constrained")
    axes: Any = figure.subplots(3, 1, sharex=True)
    manoeuvre, length_s = found.task.manoeuvre, found.time_s
    R = manoeuvre.attitudes(found.choice.phase, 0.0, length_s, length_s / STEPS).as_matrix()
    time_s = np.linspace(0.0, length_s, len(R))
    yaw, roll = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0])), np.arctan2(R[:, 2, 1], R[:, 2, 2])
    angles = np.degrees(np.column_stack([yaw, np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0)), roll]))
    for axis, values, name, colour in zip(axes, angles.T, ("yaw", "pitch", "roll"), XYZ, strict=True):
        axis.plot(time_s, values, color=colour)
        axis.set_ylabel(f"{name} (°)")
    axes[-1].set_xlabel("time (s)")
    return figure


def draw_gains(found: LegSequence) -> Figure:
    """The goal's error after each leg that pays, over the time flown, and after the one that no longer does."""
    figure = Figure(figsize=(WIDTH_IN, 3.0), layout="constrained")
    axis: Any = figure.subplots()
    legs = [*found.legs, *([found.idle] if found.idle else [])]
    time_s = np.cumsum([leg.choice.phase.duration_s for leg in legs])
    axis.plot(time_s[: len(found.legs)], [leg.after for leg in found.legs], "o-", color=LINES[0], label="pays")
    if found.idle:
        axis.plot(time_s[-1:], [found.idle.after], "o", color=RAW, label="no longer pays")
    goal = found.task.goal
    axis.set(xlabel="time flown (s)", ylabel=f"{goal.short} ({symbol(goal.unit)})", yscale="log")
    axis.legend()
    return figure


def draw_design(found: Plan) -> Figure:
    """The field's direction in the body at the legs, and in the optimal design; rings: of one that stays in place."""
    figure = Figure(figsize=(WIDTH_IN, 4.0), layout="constrained")
    axis: Any = figure.subplots()
    legs = Rotation.from_euler("ZYX", [leg.angles_deg for leg in found.choice.legs], degrees=True)
    amounts = np.array([length for _, length in found.task.manoeuvre.times_s(found.choice.phase)])
    _design(axis, found, found.least, color=RAW, linewidth=0, label="optimal design")
    for half, label in zip(found.task.manoeuvre.halves(legs), ("legs", "_mirror"), strict=False):
        _dots(axis, found, half, amounts, color=LINES[0], linewidth=0, label=label)
    if found.staying is not None:
        _design(axis, found, found.staying, facecolor="none", edgecolor=LINES[1], label="best in its place")
    axis.set(xlabel="about the body's z axis, from x (°)", ylabel="from the body's z axis (°)", xlim=(-180, 180))
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _design(axis: Any, found: Plan, least: Limit, **how: Any) -> None:
    """Dots for a limit's attitudes."""
    seen = least.weights > VISIBLE
    _dots(axis, found, least.attitudes[seen], least.weights[seen], **how)


def _dots(axis: Any, found: Plan, attitudes: Rotation, weights: Array, **how: Any) -> None:
    """A dot for each attitude (m), as large as its weight (m,)."""
    about, off = _directions(found, attitudes)
    axis.scatter(about, off, s=AREA * weights / weights.sum(), alpha=0.7, **how)


def _directions(found: Plan, attitudes: Rotation) -> tuple[Array, Array]:
    """Angle about z and from z (m,) of the field in the body, degrees."""
    enu_nT = found.task.known.field_enu_nT
    assert enu_nT is not None
    x, y, z = attitudes.inv().apply(enu_nT / np.linalg.norm(enu_nT)).T
    return np.degrees(np.arctan2(y, x)), np.degrees(np.arccos(np.clip(z, -1.0, 1.0)))
