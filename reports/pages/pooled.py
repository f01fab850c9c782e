"""Page of a pooled diagnosis: effects common to all recordings, coefficients by recording, gap of each recording."""

from __future__ import annotations

from functools import partial
from urllib.parse import quote

from markupsafe import Markup

from reports.pages import section
from reports.pages.diagnosis import answered
from reports.pages.template import render_page
from reports.plots.pooled import draw_coefficients, draw_gaps
from reports.presentation.diagnosis import GAP_HEADS
from reports.presentation.pooled import PresentedEffect, PresentedPool


def pooled_page(pooled: PresentedPool, title: str, folders: tuple[str, ...]) -> str:
    """Return the page as self-contained HTML; `folders` beside the page hold the diagnosis of each recording."""

    def drawn(effects: tuple[PresentedEffect, ...]) -> list[tuple[PresentedEffect, Markup]]:
        titles = (f"{one.name} by {pooled.scope.noun}" for one in effects)
        draws = (partial(draw_coefficients, pooled, one) for one in effects)
        return list(zip(effects, map(section.figure_html, draws, titles), strict=True))

    values = {
        "each_heads": (pooled.scope.noun, *GAP_HEADS[1:], "own verdict"),
        "effects": drawn(pooled.common),
        "alone": drawn(pooled.single),
        "gaps": [*map(_linked, pooled.gaps, folders), *pooled.gaps[len(folders) :]],
        "picture": section.figure_html(partial(draw_gaps, pooled), f"The gap of each {pooled.scope.noun}"),
        "own": list(zip(pooled.names, folders, (one.sentence for one in pooled.each), strict=True)),
    }
    return render_page("pooled.html", answered(pooled, title) | values)


def _linked(row: tuple[str, ...], folder: str) -> tuple[str, ...]:
    """Return a recording's row, its name linked to the recording's own page."""
    return Markup('<a href="{}/report.html">{}</a>').format(quote(folder), row[0]), *row[1:]
