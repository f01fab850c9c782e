"""Sections of a page: a heading, a caption and a figure, which zooms where plotly can draw the figure.

A new section of a page: one ``draw_...`` function in `reports.plots` and one `Section` in the page's ``SECTIONS``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

from markupsafe import Markup

from reports.pages.packed import packed
from reports.plots.interactive import NotInteractive, interactive
from reports.plots.style import Figure, data_url, styled

PLOT_CLASS = 'class="plot"'
"""HTML attribute of the place where plotly draws a figure."""


@dataclass(frozen=True)
class Section:
    """A figure of a result on the result's page: heading, caption, drawing function, and results it applies to.

    key : anchor of the section in the page, empty for no anchor.
    """

    title: str
    caption: str
    draw: Callable[[Any], Figure]
    applies: Callable[[Any], bool] = lambda result: True
    key: str = ""


@dataclass(frozen=True)
class DrawnSection:
    """A section with its figure as HTML, for the macro of ``section.html``."""

    title: str
    caption: str
    picture: Markup
    key: str = ""

    @classmethod
    def of(cls, title: str, caption: str, draw: Callable[[], Figure], key: str = "") -> DrawnSection:
        """Draw one section."""
        return cls(title, caption, figure_html(draw, title), key)


def drawn_sections(sections: Iterable[Section], result: Any, suffix: str = "") -> list[DrawnSection]:
    """Draw the sections that apply to a result; `suffix` ends every title, for instance with a sensor's number."""
    applying = (section for section in sections if section.applies(result))
    return [DrawnSection.of(one.title + suffix, one.caption, partial(one.draw, result), one.key) for one in applying]


def figure_html(draw: Callable[[], Figure], title: str) -> Markup:
    """Return a figure as HTML: a plotly plot, or a picture where plotly cannot draw the figure.

    title : text for screen readers.
    """
    with styled():
        figure = draw()
        try:
            plot = interactive(figure)
        except NotInteractive:
            return Markup('<img src="{}" alt="{}">').format(data_url(figure), title)
    place = Markup(f'<div {PLOT_CLASS} role="img" aria-label="{{}}" style="height: {{}}px"></div>')
    return place.format(title, plot.layout["height"]) + packed(plot.json())
