"""Nothing that a plot draws is lost where plotly shows it: artists and points in, traces and points out."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure

from reports.plots.interactive import NotInteractive, interactive
from reports.plots.style import styled
from tests.conftest import ROOT
from tests.reports.plots.examples import EXAMPLES

PICTURES = {
    "diagnosis.draw_map": "colour bar",
    "diagnosis.draw_ranking": "symlog",
    "field.draw_clouds": "SubFigure",
    "field.draw_sphere": "SubFigure",
    "inspection.draw_coverage": "without frame",
    "inspection.draw_directions": "without frame",
    "motion.draw_path": "3d",
}
"""Plots that a page shows as a picture, and what of them plotly cannot draw."""


def drawing_functions() -> Iterator[str]:
    """Every public function that returns a figure, by module or paper."""
    for path in [*(ROOT / "reports" / "plots").glob("*.py"), *(ROOT / "papers").glob("*/figures.py")]:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            figure = isinstance(node, ast.FunctionDef) and node.returns and ast.unparse(node.returns) == "Figure"
            if figure and not node.name.startswith("_"):
                yield f"{module_of(path)}.{node.name}"


def module_of(path: Path) -> str:
    return path.parent.name if path.name == "figures.py" else path.stem


def test_every_plot_has_an_example() -> None:
    assert set(EXAMPLES) == set(drawing_functions())


def points_of(artist: Any) -> int:
    """Number of finite points of a line, a scatter plot, a filled band or a bar."""
    if hasattr(artist, "get_xydata"):
        points = artist.get_xydata()
    elif isinstance(artist, PathCollection):
        points = artist.get_offsets()
    elif isinstance(artist, LineCollection):
        points = np.concatenate(artist.get_segments())
    elif hasattr(artist, "get_paths"):
        points = np.concatenate([path.vertices for path in artist.get_paths()])
    else:
        points = artist.get_path().vertices
    return int(np.isfinite(np.asarray(points, dtype=float)).all(axis=1).sum())


def crosses(artist: Any, axis: Any) -> bool:
    """Whether an artist runs across the whole panel: axvline, axhline, axvspan, axhspan."""
    transform = getattr(artist, "get_data_transform", artist.get_transform)()
    return any(transform is one for one in (axis.get_xaxis_transform(), axis.get_yaxis_transform()))


def drawn(figure: Figure) -> tuple[int, int, int, int]:
    """Number of traces, their points, shapes and notes that the figure's artists make."""
    traces = points = shapes = notes = 0
    for axis in [axis for axis in figure.axes if axis.get_visible()]:
        artists = [one for one in (*axis.lines, *axis.collections, *axis.patches) if one.get_visible()]
        artists = [one for one in artists if not hasattr(one, "get_xydata") or len(one.get_xydata())]
        across = sum(crosses(one, axis) for one in artists)
        traces, shapes = traces + len(artists) - across, shapes + across
        points += sum(points_of(one) for one in artists if not crosses(one, axis))
        notes += sum(bool(text.get_text()) for text in axis.texts) + bool(axis.get_title(loc="left"))
    return traces, points, shapes, notes


@pytest.mark.parametrize("name", EXAMPLES)
def test_nothing_drawn_is_lost(name: str) -> None:
    with styled():
        figure = EXAMPLES[name]()
        if name in PICTURES:
            with pytest.raises(NotInteractive, match=PICTURES[name]):
                interactive(figure)
            return
        expected, plot = drawn(figure), interactive(figure)
    points = sum(x is not None and y is not None for one in plot.data for x, y in zip(one["x"], one["y"], strict=True))
    layout = plot.layout
    assert (len(plot.data), points, len(layout["shapes"]), len(layout["annotations"])) == expected
    assert len(plot.data) > 0
