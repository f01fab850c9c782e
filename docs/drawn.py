"""The gallery's pictures: which figure of an example is shown, in the report's style, and the order of the groups."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from reports.plots.style import STYLE

DPI = 100
GROUPS = ("effects", "motions", "logs", "calibrations", "scores", "plans", "verdicts")


def in_style(_gallery: Any, _file: str) -> None:
    """Draw as the reports do."""
    matplotlib.rcParams.update(STYLE)


def last_figure(_block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """The figure that a block ends with, as a picture; pyplot's own figures are found by the gallery itself."""
    figure = variables["example_globals"].get("___")
    if not isinstance(figure, Figure) or matplotlib.pyplot.fignum_exists(getattr(figure, "number", -1)):
        return ""
    path = next(variables["image_path_iterator"])
    figure.savefig(path, dpi=DPI)
    return str(figure_rst([path], gallery["src_dir"]))
