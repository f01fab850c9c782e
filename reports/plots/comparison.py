"""Plots of a comparison: scores over a swept value, distributions, ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from reports.palette import INK, LINES, RAW, SOFT
from reports.plots.style import DASHES, legend_at_right, panels
from scenarios.arrays import Array
from validation.comparison.statistics import Interval, mean_ranks, median
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import ScoreDefinition

DECADE = 10.0
BOX = (5, 25, 50, 75, 95)
"""Percentiles that a calibrator's distribution is drawn by: whiskers, box, median."""


def draw_over(table: TrialTable, score: ScoreDefinition, key: str) -> Figure:
    """Draw the median of a score with interval over a swept value, a line per calibrator and for no correction."""
    figure, axis = panels(4.4)
    places = {point: values[key] for point, values in _line_of_points(table, key).items()}
    x = _value_axis(axis, list(places.values()))
    for number, name in enumerate(table.calibrators):
        found = [median(table.values(score.column, name, point)) for point in places]
        dash = DASHES[number // len(LINES) % len(DASHES)]
        colour = LINES[number % len(LINES)] if name in table.candidates else RAW
        _draw_medians(axis, x, found, color=colour, linestyle=dash, label=name)
    axis.set(yscale="log", xlabel=key, ylabel=_title(score))
    legend_at_right(axis)
    return figure


def _value_axis(axis: Any, values: list[Any]) -> Array:
    """Return the abscissae of swept values: numbers by size, logarithmic over a decade or more; words in a row."""
    if not all(isinstance(value, int | float) for value in values):
        axis.set_xticks(range(len(values)), [str(value) for value in values])
        return np.arange(len(values), dtype=np.float64)
    x = np.array(values, dtype=np.float64)
    if x.min() > 0 and x.max() >= DECADE * x.min():
        axis.set_xscale("log")
    return x


def _draw_medians(axis: Any, x: Array, found: list[Interval], **look: Any) -> None:
    """Draw medians as dots on a line, and each interval as an upright line."""
    axis.plot(x, _finite([one.value for one in found]), marker="o", markersize=4, **look)
    for place, one in zip(x, found, strict=True):
        axis.plot([place, place], _finite([one.low, one.high]), color=look["color"], linewidth=1.6, alpha=0.6)


def _line_of_points(table: TrialTable, key: str) -> dict[int, dict[str, Any]]:
    """Return the points along a swept key, with the remaining keys as at the first point."""
    first = table.points[0]
    return {
        point: values
        for point, values in table.points.items()
        if all(values[other] == first[other] for other in table.swept if other != key)
    }


def draw_distributions(table: TrialTable, score: ScoreDefinition, point: int) -> Figure:
    """Draw each calibrator's score over the trials: 5th to 95th percentile as line, quartiles as bar, median as dot."""
    names = sorted(table.calibrators, key=lambda name: median(table.values(score.column, name, point)).value)
    figure, axis = panels(0.36 * len(names) + 1.1)
    for row, name in enumerate(names):
        values = _finite(table.values(score.column, name, point))
        _draw_box(axis, row, values[values > 0], RAW if name not in table.candidates else LINES[0])
    axis.set(xscale="log", xlabel=_title(score), ylim=(len(names) - 0.4, -0.6))
    axis.set_yticks(range(len(names)), names)
    axis.grid(visible=False, axis="y")
    return figure


def _draw_box(axis: Any, row: int, values: Array, colour: str) -> None:
    """Draw the percentiles BOX of finite values (n,) at a row, or words for no value."""
    if not values.size:
        axis.annotate("no estimate", (0.01, row), xycoords=("axes fraction", "data"), va="center", color=SOFT)
        return
    least, low, middle, high, most = np.percentile(values, BOX)
    axis.plot([least, most], [row, row], color=colour, linewidth=1.2)
    axis.plot([low, high], [row, row], color=colour, linewidth=7, solid_capstyle="butt", alpha=0.45)
    axis.plot([middle], [row], "o", color=colour, markersize=5)


def draw_ranks(table: TrialTable, score: ScoreDefinition, point: int) -> Figure:
    """Draw the mean rank of each calibrator; a bar joins calibrators without significant difference (Nemenyi test)."""
    ranks = mean_ranks({name: table.values(score.column, name, point) for name in table.candidates})
    ordered = sorted(ranks.mean.items(), key=lambda item: item[1])
    figure, axis = panels(0.34 * len(ordered) + 1.2)
    for row, (_, rank) in enumerate(ordered):
        reach = [other for _, other in ordered[row:] if other - rank <= ranks.critical]
        axis.plot([rank, max(reach)], [row, row], color=SOFT, linewidth=2.5, alpha=0.5)
        axis.plot([rank], [row], "o", color=LINES[0], markersize=7)
        axis.annotate(f"{rank:.2f}", (rank, row), xytext=(0, 7), textcoords="offset points", ha="center", color=INK)
    axis.set(xlabel="mean rank, 1 is best", xlim=(0.5, len(ordered) + 0.5), ylim=(len(ordered) - 0.4, -0.9))
    axis.set_yticks(range(len(ordered)), [name for name, _ in ordered])
    axis.set_title(f"critical difference {ranks.critical:.2f}")
    return figure


def _title(score: ScoreDefinition) -> str:
    return f"{score.short} ({score.unit})" if score.unit else score.short


def _finite(values: Any) -> Array:
    """Return values (n,) with NaN for infinity, which is not drawn."""
    array = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(array), array, np.nan)
