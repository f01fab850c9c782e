"""Plots of a plan: attitudes over time, and directions of the field in the body frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from reports.palette import LINES, RAW, XYZ
from reports.plots.style import legend_at_right, panels
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


def draw_angles(plan: Plan) -> Figure:
    """Draw yaw, pitch and roll over time, a panel each."""
    figure, axes = panels(5.0, 3, 1, sharex=True)
    manoeuvre, length_s = plan.task.manoeuvre, plan.time_s
    R = manoeuvre.attitudes(plan.choice.phase, 0.0, length_s, length_s / STEPS).as_matrix()
    time_s = np.linspace(0.0, length_s, len(R))
    yaw, roll = (np.unwrap(np.arctan2(*of)) for of in ((R[:, 1, 0], R[:, 0, 0]), (R[:, 2, 1], R[:, 2, 2])))
    angles = np.degrees(np.column_stack([yaw, np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0)), roll]))
    for axis, values, name, colour in zip(axes, angles.T, ("yaw", "pitch", "roll"), XYZ, strict=True):
        axis.plot(time_s, values, color=colour)
        axis.set_ylabel(f"{name} (°)")
    axes[-1].set_xlabel("time (s)")
    return figure


def draw_gains(sequence: LegSequence) -> Figure:
    """Draw the goal's error over the time flown, after each leg that pays and after the first leg that does not."""
    figure, axis = panels(3.0)
    legs = [*sequence.legs, *([sequence.idle] if sequence.idle else [])]
    time_s = np.cumsum([leg.choice.phase.duration_s for leg in legs])
    axis.plot(time_s[: len(sequence.legs)], [leg.after for leg in sequence.legs], "o-", color=LINES[0], label="pays")
    if sequence.idle:
        axis.plot(time_s[-1:], [sequence.idle.after], "o", color=RAW, label="no longer pays")
    goal = sequence.task.goal
    axis.set(xlabel="time flown (s)", ylabel=f"{goal.short} ({symbol(goal.unit)})", yscale="log")
    axis.legend()
    return figure


def draw_design(plan: Plan) -> Figure:
    """Draw the field's direction in the body frame at the legs and in the optimal design; rings: design in place."""
    figure, axis = panels(4.0)
    legs = Rotation.from_euler("ZYX", [leg.angles_deg for leg in plan.choice.legs], degrees=True)
    amounts = np.array([length for _, length in plan.task.manoeuvre.times_s(plan.choice.phase)])
    _design(axis, plan, plan.least, color=RAW, linewidth=0, label="optimal design")
    for half, label in zip(plan.task.manoeuvre.halves(legs), ("legs", "_mirror"), strict=False):
        _dots(axis, plan, half, amounts, color=LINES[0], linewidth=0, label=label)
    if plan.staying is not None:
        _design(axis, plan, plan.staying, facecolor="none", edgecolor=LINES[1], label="best in place")
    axis.set(xlabel="about the body's z axis, from x (°)", ylabel="from the body's z axis (°)", xlim=(-180, 180))
    legend_at_right(axis)
    return figure


def _design(axis: Any, plan: Plan, least: Limit, **how: Any) -> None:
    """Draw dots for the attitudes of a limit."""
    seen = least.weights > VISIBLE
    _dots(axis, plan, least.attitudes[seen], least.weights[seen], **how)


def _dots(axis: Any, plan: Plan, attitudes: Rotation, weights: Array, **how: Any) -> None:
    """Draw a dot for each of m attitudes, with area in proportion to the weight (m,)."""
    about, off = _directions(plan, attitudes)
    axis.scatter(about, off, s=AREA * weights / weights.sum(), alpha=0.7, **how)


def _directions(plan: Plan, attitudes: Rotation) -> tuple[Array, Array]:
    """Return the angle about z and the angle from z (m,) of the field in the body frame, degrees."""
    enu_nT = plan.task.known.field_enu_nT
    assert enu_nT is not None
    x, y, z = attitudes.inv().apply(enu_nT / np.linalg.norm(enu_nT)).T
    return np.degrees(np.arctan2(y, x)), np.degrees(np.arccos(np.clip(z, -1.0, 1.0)))
