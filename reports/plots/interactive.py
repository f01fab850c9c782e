"""A figure as one that zooms and toggles: read from matplotlib's artists, shown by plotly in the page.

So each picture is drawn once, for pages, documents and notebooks alike.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

from scenarios.arrays import Array

PX_IN = 96.0
DIGITS = 6
"""Significant digits of a point: a page is wide a few thousand pixels."""
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
NAME = re.compile(r"[A-Za-z]")
"""How the text of a tick begins that is no number."""


class NotInteractive(Exception):
    """A figure with something that only a picture shows: a surface, filled cells, a scale of colours."""


@dataclass
class Plot:
    """A figure for plotly: traces and layout, as its JSON has them."""

    data: list[dict[str, Any]] = field(default_factory=list)
    layout: dict[str, Any] = field(default_factory=dict)

    def json(self) -> str:
        """One JSON object that may stand inside a page's script element."""
        return json.dumps({"data": self.data, "layout": self.layout}, separators=(",", ":")).replace("</", "<\\/")


def interactive(figure: Figure) -> Plot:
    """The figure's lines, points, bars, bands, marks and texts; NotInteractive where there is anything else."""
    axes = [axis for axis in figure.axes if axis.get_visible()]
    for axis in axes:
        _check(axis)
    if engine := figure.get_layout_engine():
        engine.execute(figure)
    plot = Plot(layout=_page(figure))
    names = dict(_named_colours(figure))
    for number, axis in enumerate(axes, start=1):
        _add_axes(plot, axis, number, axes)
        plot.data += _traces(axis, number, names)
        plot.layout["shapes"] += _bands(axis, number)
        plot.layout["annotations"] += _texts(axis, number)
    _name_each_once(plot.data)
    return plot


def _page(figure: Figure) -> dict[str, Any]:
    """What holds for the whole figure."""
    return {
        "height": round(figure.get_figheight() * PX_IN) + 60,
        "margin": {"l": 0, "r": 14, "t": 40, "b": 76},
        "font": {"size": 11, "color": matplotlib.rcParams["text.color"], "family": "system-ui, sans-serif"},
        "legend": {"orientation": "h", "yref": "container", "yanchor": "bottom", "y": 0, "x": 0},
        "hovermode": "closest",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "shapes": [],
        "annotations": [],
    }


def _check(axis: Any) -> None:
    unknown = [one for one in axis.collections if not hasattr(one, "get_offsets") or len(one.get_paths()) > 1]
    if axis.name != "rectilinear" or unknown or axis.images or not axis.axison or _is_scale_of_colours(axis):
        raise NotInteractive


def _is_scale_of_colours(axis: Any) -> bool:
    return bool(axis.get_label() == "<colorbar>")


def _ref(letter: str, number: int) -> str:
    """How plotly calls an axis of the first panel, the second, ...: x, x2, ..."""
    return letter if number == 1 else f"{letter}{number}"


def _add_axes(plot: Plot, axis: Any, number: int, axes: list[Any]) -> None:
    """The two axes of a panel at its place; panels that share an axis zoom together."""
    box = axis.get_position()
    for letter, sides in (("x", (box.x0, box.x1)), ("y", (box.y0, box.y1))):
        one = getattr(axis, f"{letter}axis")
        shared = getattr(axis, f"get_shared_{letter}_axes")()
        first = next(k for k, other in enumerate(axes, start=1) if other is axis or shared.joined(other, axis))
        found = _axis(one, getattr(axis, f"get_{letter}lim")())
        found |= {"domain": _domain(axes, letter, sides), "anchor": _ref("yx"[letter == "y"], number)}
        if first != number:
            found["matches"] = _ref(letter, first)
        plot.layout[_ref(f"{letter}axis", number)] = found
    if axis.get_aspect() == 1.0:
        plot.layout[_ref("yaxis", number)] |= {"scaleanchor": _ref("x", number)}
    if axis.get_title(loc="left") or axis.get_title():
        plot.layout["annotations"].append(_title(axis, number))


def _domain(axes: list[Any], letter: str, sides: tuple[float, float]) -> list[float]:
    """A panel's place, of the space that all panels take: labels and legend find their own beside it."""
    boxes = [axis.get_position() for axis in axes]
    low, high = min(getattr(box, f"{letter}0") for box in boxes), max(getattr(box, f"{letter}1") for box in boxes)
    return [_short(min(max((side - low) / (high - low), 0.0), 1.0)) for side in sides]


def _axis(one: Any, limits: tuple[float, float]) -> dict[str, Any]:
    """Label, range and ticks of an axis; ticks with words of their own are kept as they are."""
    scale = one.get_scale()
    if scale not in ("linear", "log"):
        raise NotInteractive
    found: dict[str, Any] = {
        "range": [_short(v) for v in (np.log10(limits) if scale == "log" else limits)],
        "type": scale,
        "title": {"text": one.get_label_text(), "standoff": 4},
        "automargin": True,
        "showticklabels": any(tick.label1.get_visible() for tick in one.get_major_ticks()[:1]),
        "gridcolor": matplotlib.rcParams["grid.color"],
        "zeroline": False,
    }
    words = [_escaped(label.get_text()) for label in one.get_ticklabels()]
    if any(NAME.match(word) for word in words):
        found |= {
            "tickmode": "array",
            "tickvals": [float(v) for v in one.get_ticklocs()],
            "ticktext": words,
        }
    return found


def _title(axis: Any, number: int) -> dict[str, Any]:
    """A panel's title above its left corner."""
    text = axis.get_title(loc="left") or axis.get_title()
    place = {"x": 0, "y": 1, "xref": f"{_ref('x', number)} domain", "yref": f"{_ref('y', number)} domain"}
    look = {"showarrow": False, "xanchor": "left", "yanchor": "bottom", "yshift": 2}
    return {"text": f"<b>{_escaped(text)}</b>", **place, **look}


def _named_colours(figure: Figure) -> Iterator[tuple[str, str]]:
    """Colours that a legend names: of the figure, and of each panel."""
    legends = [*figure.legends, *(axis.get_legend() for axis in figure.axes)]
    for legend in filter(None, legends):
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            if isinstance(handle, Line2D):
                yield to_hex(handle.get_color()), text.get_text()


def _traces(axis: Any, number: int, names: dict[str, str]) -> Iterator[dict[str, Any]]:
    where = {"xaxis": _ref("x", number), "yaxis": _ref("y", number)}
    for line in axis.lines:
        if line.get_transform() == axis.transData and len(line.get_xdata()):
            yield _line(line, names) | where
    for dots in axis.collections:
        yield _points(dots) | where
    for bar in axis.patches:
        if isinstance(bar, Rectangle) and bar.get_data_transform() == axis.transData:
            yield _bar(bar, axis) | where


def _line(line: Any, names: dict[str, str]) -> dict[str, Any]:
    colour, label = to_hex(line.get_color()), str(line.get_label())
    name = names.get(colour, "") if label.startswith("_") else label
    x, y = (_rounded(values) for values in line.get_data(orig=False))
    marked = line.get_marker() not in ("None", "", None)
    drawn = line.get_linestyle() not in ("None", "", " ")
    return {
        "type": "scattergl" if len(x) > 20_000 else "scatter",
        "mode": "+".join(["lines"] * drawn + ["markers"] * marked),
        "x": x,
        "y": y,
        "name": _escaped(name),
        "opacity": line.get_alpha() or 1.0,
        "line": {"color": colour, "width": 1.2 * line.get_linewidth(), "dash": _dash(line)},
        "marker": {"color": colour, "size": 1.3 * line.get_markersize()},
        "connectgaps": False,
    }


def _dash(line: Any) -> str:
    """The nearest of plotly's dashes; matplotlib calls a pattern of its own "--"."""
    return DASHES.get(line.get_linestyle(), "dash")


def _points(dots: Any) -> dict[str, Any]:
    x, y = np.asarray(dots.get_offsets()).T
    colours = [to_hex(colour) for colour in dots.get_facecolors()]
    marker = {"size": 4, "color": colours[0] if len(colours) == 1 else colours}
    return {"type": "scattergl", "mode": "markers", "x": _rounded(x), "y": _rounded(y), "name": "", "marker": marker}


def _bar(bar: Rectangle, axis: Any) -> dict[str, Any]:
    """A bar as a filled outline: as wide and as long as it was drawn, whichever way it lies."""
    (x, y), width, height = bar.get_xy(), bar.get_width(), bar.get_height()
    corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])
    colour = to_hex(bar.get_facecolor())
    outline = {"x": _rounded(corners[:, 0]), "y": _rounded(corners[:, 1])}
    return {"type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": colour, "name": "",
            "line": {"color": colour, "width": 0}, "hoveron": "fills", **outline}  # fmt: skip


def _bands(axis: Any, number: int) -> Iterator[dict[str, Any]]:
    """Bands and lines that run across a whole panel."""
    high = {"xref": _ref("x", number), "yref": f"{_ref('y', number)} domain"}
    wide = {"xref": f"{_ref('x', number)} domain", "yref": _ref("y", number)}
    for patch in axis.patches:
        if isinstance(patch, Rectangle) and patch.get_data_transform() == axis.get_xaxis_transform():
            yield _band(patch) | high
    for line in axis.lines:
        if line.get_transform() == axis.get_yaxis_transform():
            yield _across(line) | wide
        elif line.get_transform() == axis.get_xaxis_transform():
            yield _across(line) | high


def _band(patch: Rectangle) -> dict[str, Any]:
    """A stretch of the horizontal axis, from the bottom of the panel to its top."""
    x, fill = patch.get_x(), {"fillcolor": to_hex(patch.get_facecolor()), "opacity": patch.get_alpha() or 1.0}
    sides = {"x0": _short(x), "x1": _short(x + patch.get_width()), "y0": 0, "y1": 1}
    return {"type": "rect", "layer": "below", "line": {"width": 0}} | sides | fill


def _across(line: Any) -> dict[str, Any]:
    """A straight line from one side of the panel to the other."""
    (x0, x1), (y0, y1) = ((_short(values[0]), _short(values[-1])) for values in line.get_data())
    look = {"color": to_hex(line.get_color()), "width": 1, "dash": _dash(line)}
    return {"type": "line", "line": look, "x0": x0, "x1": x1, "y0": y0, "y1": y1}


def _texts(axis: Any, number: int) -> Iterator[dict[str, Any]]:
    """Notes beside what they belong to, in the panel's own coordinates."""
    for text in axis.texts:
        if not text.get_text() or not text.get_visible():
            continue
        (x, y), coords = (text.xy, text.xycoords) if isinstance(text, Annotation) else (text.get_position(), "data")
        of_x, of_y = coords if isinstance(coords, tuple) else (coords, coords)
        dx, dy = text.get_position() if isinstance(text, Annotation) and text.anncoords == "offset points" else (0, 0)
        yield {
            "text": _escaped(text.get_text()),
            "x": _place(x, axis.get_xscale(), of_x),
            "y": _place(y, axis.get_yscale(), of_y),
            "xref": _ref("x", number) + ("" if of_x == "data" else " domain"),
            "yref": _ref("y", number) + ("" if of_y == "data" else " domain"),
            "xshift": dx,
            "yshift": dy,
            "showarrow": False,
            "textangle": -text.get_rotation(),
            "xanchor": text.get_ha(),
            "yanchor": {"center": "middle", "baseline": "bottom"}.get(text.get_va(), text.get_va()),
            "font": {"color": to_hex(text.get_color()), "size": 10},
        }


def _place(value: float, scale: str, of: str) -> float:
    """Where a note stands; on a logarithmic axis plotly wants the exponent."""
    return _short(np.log10(value) if of == "data" and scale == "log" else value)


def _name_each_once(data: Iterable[dict[str, Any]]) -> None:
    """Traces of one name toggle together, and the legend names each once."""
    seen = set[str]()
    for trace in data:
        name = trace["name"]
        trace |= {"showlegend": bool(name) and name not in seen, "legendgroup": name or None}
        if not name:
            trace |= {"hoverinfo": "x+y"}
        seen.add(name)


def _rounded(values: Any) -> list[float | None]:
    """Numbers with as many digits as can be seen; what is not a number leaves a gap."""
    array: Array = np.asarray(values, dtype=np.float64)
    texts = np.char.mod(f"%.{DIGITS}g", array)
    return [float(text) if finite else None for text, finite in zip(texts, np.isfinite(array), strict=True)]


def _short(value: Any) -> float:
    return float(f"{float(value):.{DIGITS}g}")


def _escaped(text: str) -> str:
    """Text of ours as plotly takes it, which reads some HTML."""
    for sign, entity in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;")):
        text = text.replace(sign, entity)
    return text
