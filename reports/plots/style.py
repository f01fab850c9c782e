"""Style of the plots, and figures as data addresses for pages."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from reports.palette import INK, SOFT, phase_colours
from scenarios.arrays import Array
from validation.scoring.outcome import Outcome
from validation.signals.thinning import envelope
from validation.text import digits, plainly

WIDTH_IN = 11.0
DASHES = ("-", "--", ":", "-.")
"""Lines of one colour, in order."""
SVG_POINTS = 10_000
"""Points of the lines of a picture that may become SVG."""
SVG_MARKS = 1000
"""Marks of scatters of a picture that may become SVG: one takes a hundred bytes and more."""
SVG_BYTES = 60_000
"""Size of an SVG that no PNG is drawn to undercut."""
DPI, TALL_DPI, TALL_IN = 140, 100, 12.0
STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelcolor": INK,
    "axes.edgecolor": "#9aa2ab",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#e9ecef",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "white",
    "path.simplify_threshold": 0.3,
    "svg.hashsalt": "magbench",
}


def styled() -> AbstractContextManager[None]:
    """Return a context in which figures are drawn in the report's style."""
    return matplotlib.rc_context(STYLE)


def panels(
    height_in: float, rows: int = 1, columns: int = 1, *, width_in: float = WIDTH_IN, **shared: Any
) -> tuple[Figure, Any]:
    """Return a new figure and its axes, as `Figure.subplots` gives them for rows and columns."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, figure.subplots(rows, columns, **shared)


def label_decades(side: Any) -> None:
    """Label 1, 2 and 5 of each decade of a logarithmic x or y axis, with all their digits."""
    side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    side.set_major_formatter(FuncFormatter(lambda value, _: plainly(value)))
    side.set_minor_formatter(NullFormatter())


def legend_at_right(axis: Any) -> None:
    """Add a legend to the right of a panel."""
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def styled_data_url(draw: Callable[[], Figure]) -> str:
    """Return a figure, drawn in the report's style, as a data address."""
    with styled():
        return data_url(draw())


def data_url(figure: Figure) -> str:
    """Return a figure as a data address: SVG for few points, else PNG where that is smaller."""
    drawn = _svg(figure) if _may_be_svg(figure) else None
    if drawn and len(drawn) <= SVG_BYTES:
        return _address("svg+xml", drawn)
    picture = _png(figure)
    return _address("svg+xml", drawn) if drawn and len(drawn) <= len(picture) else _address("png", picture)


def _may_be_svg(figure: Figure) -> bool:
    """Return whether a figure has few enough points of lines and marks of scatters."""
    points = sum(np.size(line.get_xdata()) for axis in figure.axes for line in axis.lines)
    marks = sum(np.shape(one.get_offsets())[0] for axis in figure.axes for one in axis.collections)
    return points <= SVG_POINTS and marks <= SVG_MARKS


def _svg(figure: Figure) -> bytes:
    file = io.BytesIO()
    FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
    _keep_layout(figure)
    return file.getvalue()


def _png(figure: Figure) -> bytes:
    """Return a PNG of at most 256 colours, a third of the size of one of all colours."""
    figure.set_dpi(DPI if figure.get_figheight() < TALL_IN else TALL_DPI)
    canvas, file = FigureCanvasAgg(figure), io.BytesIO()
    canvas.draw()
    _keep_layout(figure)
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    picture.quantize(256, dither=Image.Dither.NONE).save(file, "PNG", optimize=True)
    return file.getvalue()


def _keep_layout(figure: Figure) -> None:
    """Leave the places of a drawn figure's panels as they are: to compute them takes as long as to draw."""
    figure.set_layout_engine("none")


def _address(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def time_scale(time_s: Array) -> tuple[float, str]:
    """Return the length of a time axis' unit in seconds, and the unit's name."""
    length_s = float(np.ptp(time_s)) if len(time_s) else 0.0
    return (1.0, "s") if length_s < 600 else (60.0, "min") if length_s < 3 * 3600 else (3600.0, "h")


def draw_phase_bands(axes: list[Any], outcome: Outcome, *, labelled: bool = True) -> None:
    """Draw the motion's phases behind time axes, labelled above the first."""
    scale, _ = time_scale(outcome.recording.time_s)
    time = outcome.recording.time_s / scale
    colours, stretches = phase_colours(outcome), outcome.phases()
    for label, first, last in stretches if len(stretches) <= 60 else []:
        low, high = time[first], time[min(last, len(time) - 1)]
        for axis in axes:
            axis.axvspan(low, high, color=colours[label], alpha=0.055, linewidth=0)
        if labelled and (high - low) > 0.06 * (time[-1] - time[0]):
            axes[0].annotate(
                label, ((low + high) / 2, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 3),
                textcoords="offset points", ha="center", fontsize=8, color=colours[label],
            )  # fmt: skip


def draw_lines(axis: Any, outcome: Outcome, values: Array, colours: tuple[str, ...], **style: Any) -> None:
    """Draw values (n,) or (n, k) over time, thinned with spikes kept."""
    scale, _ = time_scale(outcome.recording.time_s)
    time, thin = envelope(outcome.recording.time_s / scale, values)
    columns = thin[:, None] if thin.ndim == 1 else thin
    labels = style.pop("labels", (None,) * columns.shape[1])
    for k in range(columns.shape[1]):
        look = {"color": colours[k % len(colours)], "linestyle": DASHES[k // len(colours) % len(DASHES)]} | style
        axis.plot(time, columns[:, k], label=labels[k], **look)


def label_time_axis(axis: Any, outcome: Outcome) -> None:
    """Set label and limits of a time axis."""
    scale, unit = time_scale(outcome.recording.time_s)
    time_s = outcome.recording.time_s
    axis.set_xlabel(f"time ({unit})")
    if time_s[-1] > time_s[0]:
        axis.set_xlim(time_s[0] / scale, time_s[-1] / scale)


def clip_outliers(axis: Any, values: Array, outliers: float = 8.0) -> None:
    """Cut the value axis where rare outliers would flatten the curve, and note the outliers' size on the plot."""
    size = np.abs(values[np.isfinite(values)])
    usual, most = (float(np.quantile(size, 0.99)), float(size.max())) if size.size else (0.0, 0.0)
    if 0 < outliers * usual < most:
        axis.set_ylim(-3 * usual, 3 * usual)
        note = f"outliers reach ±{digits(most)} nT, beyond this axis"
        box = {"fc": "white", "ec": "none", "pad": 1.5}
        axis.annotate(note, (1, 1), xytext=(-3, -3), xycoords="axes fraction", textcoords="offset points",
                      ha="right", va="top", fontsize=8, color=SOFT, bbox=box)  # fmt: skip
