"""Plots of a bound over the values of a key."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from reports.palette import INK, LINES, XYZ
from reports.plots.style import legend_at_right, panels
from validation.bound.information import AXES
from validation.bound.query import BoundAnswer, WhatIf
from validation.text import symbol


def draw_offset(what_if: WhatIf) -> Figure:
    """Draw the least standard deviation of the offset and of its components over the key's values."""
    figure, axis = panels(3.8)
    for k, (name, colour) in enumerate(zip(AXES, XYZ, strict=True)):
        _draw(axis, what_if, lambda one, k=k: one.bound.offset_std_nT[k], color=colour, label=name)  # type: ignore[misc]
    _draw(axis, what_if, lambda one: one.bound.offset_rms_nT, color=INK, linestyle="--", label="together")
    axis.set(ylabel="least offset error (nT)", xlabel=what_if.key)
    legend_at_right(axis)
    return figure


def draw_components(answer: BoundAnswer) -> Figure:
    """Draw the least standard deviation of each component of the offset; an unobservable component has no bar."""
    figure, axis = panels(2.4)
    std = answer.bound.offset_std_nT
    axis.barh(list(AXES), np.where(np.isfinite(std), std, np.nan), color=XYZ)
    axis.set_ylim(len(AXES) - 0.4, -0.6)
    axis.set(xlabel="least offset error (nT)")
    return figure


def draw_score_bounds(what_if: WhatIf) -> Figure:
    """Draw the bound of each score over the key's values, a panel per score."""
    used = what_if.answers[0].used
    figure, axes = panels(2.2 * len(used), len(used), 1, sharex=True, squeeze=False)
    for k, (axis, use) in enumerate(zip(axes[:, 0], used, strict=True)):
        _draw(axis, what_if, lambda one, k=k: one.used[k].value, color=LINES[0])  # type: ignore[misc]
        axis.set(ylabel=f"{use.meaning.short} ({symbol(use.meaning.unit)})")
    axes[-1, 0].set(xlabel=what_if.key)
    return figure


def _draw(axis: Any, what_if: WhatIf, value: Callable[[BoundAnswer], float], **look: Any) -> None:
    """Draw a line of values on a logarithmic axis; an unobservable value has no point."""
    y = np.array([value(one) for one in what_if.answers])
    numbers = all(isinstance(one, int | float) for one in what_if.values)
    x = np.array(what_if.values, dtype=np.float64) if numbers else np.arange(len(y))
    axis.plot(x, np.where(np.isfinite(y), y, np.nan), marker="o", markersize=4, **look)
    if not numbers:
        axis.set_xticks(x, [str(one) for one in what_if.values])
    if (np.isfinite(y) & (y > 0)).any():
        axis.set_yscale("log")
