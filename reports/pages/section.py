"""A figure as part of a page: one that zooms and toggles where it can, else a picture."""

from __future__ import annotations

from collections.abc import Callable

from markupsafe import Markup

from reports.plots.interactive import NotInteractive, interactive
from reports.plots.style import Figure, data_url, styled

PLOT_CLASS = 'class="plot"'
"""What marks the place of a figure that plotly draws."""


def figure_html(draw: Callable[[], Figure], title: str) -> Markup:
    """The figure's part of a page; title: what it shows, for readers who do not see it."""
    with styled():
        figure = draw()
        try:
            plot = interactive(figure)
        except NotInteractive:
            return Markup('<img src="{}" alt="{}">').format(data_url(figure), title)
    place = Markup(f'<div {PLOT_CLASS} role="img" aria-label="{{}}" style="height: {{}}px"></div>')
    return place.format(title, plot.layout["height"]) + Markup(
        f'<script type="application/json">{plot.json()}</script>'
    )
