"""Pictures of a bound: the least errors over a value that is asked about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from reports.palette import INK, LINES, XYZ
from reports.plots.style import WIDTH_IN
from validation.bound.information import AXES
from validation.bound.query import BoundAnswer, WhatIf
from validation.text import symbol


def draw_offset(found: WhatIf) -> Figure:
    """Least standard deviation of each component of the offset, and of all together, over the value."""
    figure = Figure(figsize=(WIDTH_IN, 3.8), layout="constrained")
    axis: Any = figure.subplots()
    for k, (name, colour) in enumerate(zip(AXES, XYZ, strict=True)):
        _draw(axis, found, lambda one, k=k: one.bound.offset_std_nT[k], color=colour, label=name)  # type: ignore[misc]
    _draw(axis, found, lambda one: one.bound.offset_rms_nT, color=INK, linestyle="--", label="together")
    axis.set(ylabel="least offset error (nT)", xlabel=found.key)
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def draw_components(found: BoundAnswer) -> Figure:
    """Least standard deviation of each component of the offset; what is not told has no bar."""
    figure = Figure(figsize=(WIDTH_IN, 2.4), layout="constrained")
    axis: Any = figure.subplots()
    std = found.bound.offset_std_nT
    axis.barh(list(AXES), np.where(np.isfinite(std), std, np.nan), color=XYZ)
    axis.invert_yaxis()
    axis.set(xlabel="least offset error (nT)")
    return figure


def draw_score_bounds(found: WhatIf) -> Figure:
    """The least error of each use over the value, a panel each."""
    used = found.answers[0].used
    figure = Figure(figsize=(WIDTH_IN, 2.2 * len(used)), layout="constrained")
    axes: Any = figure.subplots(len(used), 1, sharex=True, squeeze=False)
    for k, (axis, use) in enumerate(zip(axes[:, 0], used, strict=True)):
        _draw(axis, found, lambda one, k=k: one.used[k].value, color=LINES[0])  # type: ignore[misc]
        axis.set(ylabel=f"{use.meaning.short} ({symbol(use.meaning.unit)})")
    axes[-1, 0].set(xlabel=found.key)
    return figure


def _draw(axis: Any, found: WhatIf, value: Callable[[BoundAnswer], float], **look: Any) -> None:
    """A line of values on a logarithmic axis; what is not told has no point."""
    y = np.array([value(one) for one in found.answers])
    numbers = all(isinstance(one, int | float) for one in found.values)
    x = np.array(found.values, dtype=np.float64) if numbers else np.arange(len(y))
    axis.plot(x, np.where(np.isfinite(y), y, np.nan), marker="o", markersize=4, **look)
    if not numbers:
        axis.set_xticks(x, [str(one) for one in found.values])
    if (np.isfinite(y) & (y > 0)).any():
        axis.set_yscale("log")
