"""Conversion of matplotlib figures to plotly figures, which zoom and whose traces toggle.

Each plot is drawn once with matplotlib; pages, documents and notebooks share the drawing. Every artist of a figure is
either converted or named in a NotInteractive error.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.spines import Spine
from matplotlib.text import Annotation, Text

from scenarios.arrays import Array

PX_IN, PX_POINT = 96.0, 96.0 / 72.0
LEFT_PX = 52
"""Least margin at the left: plotly's own is too small for label and ticks, which then overlap."""
DIGITS = 6
"""Significant digits of a limit, a size or a place."""
STEPS_A_SPAN, STEPS_A_VALUE = 2e4, 1e4
"""Steps of a coordinate in the span of its trace, and in its own size, whichever are finer: a page is a few thousand
pixels wide, and a logarithmic axis shows values of every size."""
PLAIN_TICKS = 6
"""Powers of ten below which tick labels have all their digits: never "20k" or "100µ" beside a unit."""
LEAST_PLAIN = 1e-4
"""Lower end of a logarithmic axis whose ticks have all their digits."""
HALF_DECADE = 0.5
"""Span of a logarithmic axis, in decades, below which each tick has room for a label."""
FEW_DECADES = 1.3
"""Span of a logarithmic axis, in decades, below which ticks between the powers of ten have labels too."""
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
MARKERS = {"o": "circle", ".": "circle", "|": "line-ns-open", "_": "line-ew-open"}
"""Plotly's symbol for each matplotlib marker in use."""
Look = tuple[str, str]
"""Colour and dash of a line, by which a legend names the lines without a label of their own."""
WORD = re.compile(r"[A-Za-z]")
"""First character of a tick label that is not a number."""


class NotInteractive(Exception):
    """Error for a figure with an artist without plotly counterpart, for instance a surface; names the artist."""


@dataclass
class Plot:
    """Traces and layout of a plotly figure, as in plotly's JSON."""

    data: list[dict[str, Any]] = field(default_factory=list)
    layout: dict[str, Any] = field(default_factory=dict)

    def json(self) -> str:
        """Return a JSON object that is safe inside a script element."""
        return json.dumps({"data": self.data, "layout": self.layout}, separators=(",", ":")).replace("</", "<\\/")


def interactive(figure: Figure) -> Plot:
    """Convert a figure's lines, points, filled areas, bars, bands and texts to plotly traces, shapes and annotations.

    Raises NotInteractive for any further artist.
    """
    beyond = [one for one in figure.get_children() if not isinstance(one, Axes | Legend) and one is not figure.patch]
    if drawn := [one for one in beyond if one.get_visible()]:
        raise _unknown(drawn[0])
    axes = [axis for axis in figure.axes if axis.get_visible()]
    for axis in axes:
        _check_axes(axis)
    if len(axes) > 1 and (engine := figure.get_layout_engine()):  # a single panel takes the whole place
        engine.execute(figure)
    plot = Plot(layout=_figure_layout(figure))
    for number, axis in enumerate(axes, start=1):
        _add_axes(plot, axis, number, axes)
        _add_artists(plot, axis, number, dict(_named_looks([*figure.legends, axis.get_legend()])))
    _name_each_once(plot.data)
    return plot


def _unknown(artist: Artist) -> NotInteractive:
    label = str(artist.get_label())
    named = "" if label.startswith("_") or not label else f" {label!r}"
    return NotInteractive(f"plotly cannot draw {type(artist).__name__}{named}")


def _figure_layout(figure: Figure) -> dict[str, Any]:
    """Return the layout common to all panels."""
    return {
        "height": round(figure.get_figheight() * PX_IN) + 60,
        "margin": {"l": LEFT_PX, "r": 14, "t": 40, "b": 76},
        "font": {"size": 11, "color": matplotlib.rcParams["text.color"], "family": "system-ui, sans-serif"},
        "legend": {"orientation": "h", "yref": "container", "yanchor": "bottom", "y": 0, "x": 0},
        "hovermode": "closest",
        "separators": ".",  # no sign between thousands, as in the page's texts
        "plot_bgcolor": "rgba(0,0,0,0)",
        "shapes": [],
        "annotations": [],
    }


def _check_axes(axis: Any) -> None:
    """Raise NotInteractive for 3-D and polar axes, colour bars and axes without frame."""
    if axis.name != "rectilinear" or not axis.axison or axis.get_label() == "<colorbar>":
        raise NotInteractive(f"plotly cannot draw axes of kind {axis.name!r}, without frame or with a colour bar")


def _ref(letter: str, number: int) -> str:
    """Return plotly's name of the x or y axis of a panel, counted from 1: x, x2, x3."""
    return letter if number == 1 else f"{letter}{number}"


def _add_axes(plot: Plot, axis: Any, number: int, axes: list[Any]) -> None:
    """Add a panel's two axes at their place; panels with shared axes zoom together."""
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
    if title := axis.get_title(loc="left") or axis.get_title():
        plot.layout["annotations"].append(_title(title, number))


def _domain(axes: list[Any], letter: str, sides: tuple[float, float]) -> list[float]:
    """Return a panel's two sides as shares of the space between the outermost panels."""
    boxes = [axis.get_position() for axis in axes]
    low, high = min(getattr(box, f"{letter}0") for box in boxes), max(getattr(box, f"{letter}1") for box in boxes)
    return [_short(min(max((side - low) / (high - low), 0.0), 1.0)) for side in sides]


def _axis(one: Any, limits: tuple[float, float]) -> dict[str, Any]:
    """Return label, range and ticks of an axis; tick labels of words are kept as drawn."""
    scale = one.get_scale()
    if scale not in ("linear", "log"):
        raise NotInteractive(f"plotly has no {scale!r} axis")
    found: dict[str, Any] = {
        **_scaled(scale, np.log10(limits) if scale == "log" else np.array(limits)),
        "title": {"text": one.get_label_text(), "standoff": 4},
        "automargin": True,
        "showticklabels": any(tick.label1.get_visible() for tick in one.get_major_ticks()[:1]),
        "gridcolor": matplotlib.rcParams["grid.color"],
        "zeroline": False,
        **_tick_numbers(scale, limits),
    }
    words = [_escaped(label.get_text()) for label in one.get_ticklabels()]
    if any(WORD.match(word) for word in words):
        found |= {"tickmode": "array", "tickvals": [float(v) for v in one.get_ticklocs()], "ticktext": words}
    return found


def _scaled(scale: str, limits: Array) -> dict[str, Any]:
    """Return scale and range (2) of an axis; of a logarithmic one, whether ticks between powers of ten have labels."""
    return {
        "type": scale,
        "range": [_short(v) for v in limits],
        **(_log_ticks(np.ptp(limits)) if scale == "log" else {}),
    }


def _log_ticks(decades: float) -> dict[str, str]:
    """Return which ticks between the powers of ten have labels: all, 2 and 5, or none."""
    if decades >= FEW_DECADES:
        return {"minorloglabels": "none"}
    return {"minorloglabels": "complete", "dtick": "D1" if decades < HALF_DECADE else "D2"}


def _tick_numbers(scale: str, limits: tuple[float, float]) -> dict[str, Any]:
    """Return how ticks are written: all digits up to a million, powers of ten beyond."""
    plain = scale == "log" and min(limits) >= LEAST_PLAIN and max(limits) <= 10.0**PLAIN_TICKS
    return {"exponentformat": "none"} if plain else {"exponentformat": "power", "minexponent": PLAIN_TICKS}


def _title(text: str, number: int) -> dict[str, Any]:
    """Return the annotation of a panel's title, above the panel's upper left corner."""
    place = {"x": 0, "y": 1, "xref": f"{_ref('x', number)} domain", "yref": f"{_ref('y', number)} domain"}
    look = {"showarrow": False, "xanchor": "left", "yanchor": "bottom", "yshift": 2}
    return {"text": f"<b>{_escaped(text)}</b>", **place, **look}


def _named_looks(legends: Iterable[Legend | None]) -> Iterator[tuple[Look, str]]:
    """Yield colour and dash of each line in the legends of the figure and of a panel, with the line's label."""
    for legend in filter(None, legends):
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            if isinstance(handle, Line2D):
                yield _look(handle), text.get_text()


def _look(line: Line2D) -> Look:
    return to_hex(line.get_color()), _dash(line)


def _add_artists(plot: Plot, axis: Any, number: int, names: dict[Look, str]) -> None:
    """Add every artist of a panel as a trace, a shape or an annotation, the rearmost first."""
    where = {"xaxis": _ref("x", number), "yaxis": _ref("y", number)}
    for artist in sorted(_drawn(axis), key=Artist.get_zorder):
        if isinstance(artist, Text):
            plot.layout["annotations"].append(_note(artist, axis, number))
        elif shape := _shape(artist, axis, number):
            plot.layout["shapes"].append(shape)
        else:
            plot.data.append(_trace(artist, axis, names) | where)


def _drawn(axis: Any) -> Iterator[Any]:
    """Yield the artists drawn on the axes, without frame, titles, legend, empty lines and empty texts."""
    titles = (axis.title, axis._left_title, axis._right_title)
    for artist in axis.get_children():
        kind = type(artist)
        frame = issubclass(kind, Spine | Axis | Legend) or artist is axis.patch or artist in titles
        no_points = issubclass(kind, Line2D) and not len(artist.get_xdata())  # made for a legend's handle
        no_text = issubclass(kind, Text) and not artist.get_text()
        if artist.get_visible() and not (frame or no_points or no_text):
            yield artist


def _trace(artist: Any, axis: Any, names: dict[Look, str]) -> dict[str, Any]:
    """Convert an artist in data coordinates to a trace; raises NotInteractive where plotly has no counterpart."""
    kind = type(artist)
    # compared by identity: by value, axes of limits 0 to 1 have data = axes coordinates
    if _transform(artist) is not axis.transData:
        raise _unknown(artist)
    if issubclass(kind, Line2D):
        return _line(artist, names)
    if issubclass(kind, PathCollection):
        return _points(artist)
    if issubclass(kind, LineCollection):
        return _line_like(artist.get_segments(), _single(artist, artist.get_colors()), artist)
    if issubclass(kind, PolyCollection):
        return _area([path.vertices for path in artist.get_paths()], artist)
    if issubclass(kind, Patch):
        outline = artist.get_patch_transform().transform_path(artist.get_path()).to_polygons(closed_only=False)
        return _area(outline, artist) if artist.fill else _line_like(outline, artist.get_edgecolor(), artist)
    raise _unknown(artist)


def _transform(artist: Any) -> Any:
    """Return the transform from an artist's own coordinates to the figure."""
    if isinstance(artist, PathCollection):
        return artist.get_offset_transform()
    return artist.get_data_transform() if isinstance(artist, Patch) else artist.get_transform()


def _single(artist: Any, values: Any) -> Any:
    """Return the only value; raises NotInteractive for an artist with several colours or symbols."""
    if len(values) != 1:
        raise _unknown(artist)
    return values[0]


def _line(line: Any, names: dict[Look, str]) -> dict[str, Any]:
    (colour, dash), label = _look(line), str(line.get_label())
    name = names.get((colour, dash), "") if label.startswith("_") else label
    x, y = (_rounded(values) for values in line.get_data(orig=False))
    marker = line.get_marker()
    marked = marker not in ("None", "", " ", None)
    drawn = line.get_linestyle() not in ("None", "", " ")
    if line.get_drawstyle() != "default" or (marked and marker not in MARKERS and not isinstance(marker, int)):
        raise NotInteractive(f"plotly cannot draw steps or the marker {marker!r}")
    return {
        "type": "scatter",
        "mode": "+".join(["lines"] * drawn + ["markers"] * marked),
        "x": x,
        "y": y,
        "name": _escaped(name),
        "opacity": line.get_alpha() or 1.0,
        "line": {"color": colour, "width": 1.2 * line.get_linewidth(), "dash": dash},
        "marker": {"color": colour, "size": 1.3 * line.get_markersize(), "symbol": MARKERS.get(marker, "circle")},
        "connectgaps": False,
    }


def _dash(line: Any) -> str:
    """Return the nearest plotly dash; matplotlib calls a custom pattern "--"."""
    return DASHES.get(line.get_linestyle(), "dash")


def _points(dots: Any) -> dict[str, Any]:
    """Convert a scatter plot: colours and areas of the points, rings where a point has no face."""
    _single(dots, dots.get_paths())
    dots.update_scalarmappable()
    x, y = np.ma.filled(np.ma.asarray(dots.get_offsets(), dtype=np.float64), np.nan).T
    hollow = not len(dots.get_facecolors())
    colours = [to_hex(colour) for colour in (dots.get_edgecolors() if hollow else dots.get_facecolors())]
    sizes = [_short(PX_POINT * np.sqrt(area)) for area in dots.get_sizes()]
    marker = {
        "size": sizes[0] if len(sizes) == 1 else sizes,
        "color": colours[0] if len(colours) == 1 else colours,
        "symbol": "circle-open" if hollow else "circle",
    }
    return {"type": "scatter", "mode": "markers", "x": _rounded(x), "y": _rounded(y), "name": _label(dots),
            "opacity": dots.get_alpha() or 1.0, "marker": marker}  # fmt: skip


def _line_like(parts: Sequence[Array], colour: Any, artist: Any) -> dict[str, Any]:
    """Convert polylines (m, 2) to a trace with a gap after each."""
    width = 1.2 * float(np.ravel(artist.get_linewidth())[0])
    line = {"color": to_hex(colour), "width": width, "dash": "solid"}
    return {"type": "scatter", "mode": "lines", "name": _label(artist), "line": line,
            "opacity": artist.get_alpha() or 1.0, **_joined(parts)}  # fmt: skip


def _area(parts: Sequence[Array], artist: Any) -> dict[str, Any]:
    """Convert closed outlines (m, 2), for instance a bar or a confidence band, to a filled trace."""
    colour = to_hex(_single(artist, np.atleast_2d(artist.get_facecolor())))
    trace = _line_like(parts, colour, artist)
    no_edge = {"line": trace["line"] | {"width": 0}, "hoveron": "fills"}
    return trace | {"fill": "toself", "fillcolor": colour, **no_edge}


def _joined(parts: Sequence[Array]) -> dict[str, list[float | None]]:
    """Return x and y of all polylines in a row, None between two of them."""
    gap = np.full((1, 2), np.nan)
    pieces = [part for each in parts for part in (np.asarray(each, dtype=np.float64), gap)]
    points = np.concatenate([*pieces, np.empty((0, 2))])[:-1]  # a bar without value has no outline
    return {"x": _rounded(points[:, 0]), "y": _rounded(points[:, 1])}


def _label(artist: Any) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") else _escaped(label)


def _shape(artist: Any, axis: Any, number: int) -> dict[str, Any] | None:
    """Convert a band or a line across the whole panel to a shape; None for every other artist."""
    high = {"xref": _ref("x", number), "yref": f"{_ref('y', number)} domain"}
    wide = {"xref": f"{_ref('x', number)} domain", "yref": _ref("y", number)}
    transform = _transform(artist)
    refs = (
        high if transform is axis.get_xaxis_transform() else wide if transform is axis.get_yaxis_transform() else None
    )
    if refs and isinstance(artist, Rectangle):
        return _band(artist) | refs
    if refs and isinstance(artist, Line2D):
        return _across(artist) | refs
    return None


def _band(patch: Rectangle) -> dict[str, Any]:
    """Return a rectangle between two values of one axis, from side to side of the panel along the other."""
    (x0, y0), (x1, y1) = patch.get_xy(), (patch.get_x() + patch.get_width(), patch.get_y() + patch.get_height())
    sides = {"x0": _short(x0), "x1": _short(x1), "y0": _short(y0), "y1": _short(y1)}
    fill = {"fillcolor": to_hex(patch.get_facecolor()), "opacity": patch.get_alpha() or 1.0}
    return {"type": "rect", "layer": "below", "line": {"width": 0}} | sides | fill


def _across(line: Any) -> dict[str, Any]:
    """Return a straight line from side to side of the panel."""
    (x0, x1), (y0, y1) = ((_short(values[0]), _short(values[-1])) for values in line.get_data())
    look = {"color": to_hex(line.get_color()), "width": 1, "dash": _dash(line)}
    pale = {"opacity": alpha} if (alpha := line.get_alpha()) else {}
    named = {"name": name, "showlegend": True} if (name := _label(line)) else {}
    return {"type": "line", "line": look, "x0": x0, "x1": x1, "y0": y0, "y1": y1, **pale, **named}


def _note(text: Any, axis: Any, number: int) -> dict[str, Any]:
    """Convert a text to an annotation in the panel's data or axes coordinates."""
    (x, y), (of_x, of_y), (dx, dy) = _position(text, axis)
    return {
        "text": _escaped(text.get_text()),
        "x": _annotation_value(x, axis.get_xscale(), of_x),
        "y": _annotation_value(y, axis.get_yscale(), of_y),
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


def _position(text: Any, axis: Any) -> tuple[Any, Any, Any]:
    """Return a text's anchor, the coordinates of x and y ("data" or "axes fraction"), and its shift in points."""
    if not isinstance(text, Annotation):
        return text.get_position(), ("data" if text.get_transform() is axis.transData else "axes fraction",) * 2, (0, 0)
    of = text.xycoords if isinstance(text.xycoords, tuple) else (text.xycoords, text.xycoords)
    shifted = text.anncoords == "offset points"
    moved = not shifted and tuple(text.get_position()) != tuple(text.xy)
    if text.arrow_patch is not None or moved or not {*of} <= {"data", "axes fraction"}:
        raise _unknown(text)
    return text.xy, of, text.get_position() if shifted else (0, 0)


def _annotation_value(value: float, scale: str, of: str) -> float:
    """Return an annotation's coordinate; on a logarithmic axis plotly expects the exponent."""
    return _short(np.log10(value) if of == "data" and scale == "log" else value)


def _name_each_once(data: Sequence[dict[str, Any]]) -> None:
    """Group the traces of each name, to toggle together with a single entry in the legend: of the least pale trace."""
    shown: dict[str, dict[str, Any]] = {}
    for trace in sorted(data, key=lambda trace: -float(trace["opacity"])):
        shown.setdefault(trace["name"], trace)
    for trace in data:
        name = trace["name"]
        trace |= {"showlegend": bool(name) and shown[name] is trace, "legendgroup": name or None}
        if not name:
            trace |= {"hoverinfo": "x+y"}


def _rounded(values: Any) -> list[float | None]:
    """Return the coordinates of a trace, rounded to decimal steps; NaN and infinity become None, a gap."""
    array: Array = np.asarray(values, dtype=np.float64)
    known = np.isfinite(array)
    sound = np.where(known, array, 0.0)
    span = float(np.ptp(array[known])) if known.any() else 0.0
    own = np.abs(sound) / STEPS_A_VALUE
    step = np.minimum(own, span / STEPS_A_SPAN) if span else own
    places = np.clip(np.ceil(-np.log10(np.where(step > 0, step, 1.0))), -300, 300)
    whole = np.rint(sound * 10.0**places)
    found = np.where(places < 0, whole * 10.0**-places, whole / 10.0**places)
    return [value if finite else None for value, finite in zip(found.tolist(), known.tolist(), strict=True)]


def _short(value: Any) -> float:
    return float(f"{float(value):.{DIGITS}g}")


def _escaped(text: str) -> str:
    """Escape signs that plotly reads as HTML."""
    for sign, entity in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;")):
        text = text.replace(sign, entity)
    return text
