"""Page of a pooled diagnosis: effects common to all recordings, coefficients by recording, gap of each recording."""

from __future__ import annotations

from functools import partial

from markupsafe import Markup

from reports.pages import section
from reports.pages.template import render_page
from reports.plots.pooled import draw_coefficients, draw_gaps
from reports.presentation.pooled import PresentedEffect, PresentedPool
from reports.presentation.stated_iron import IRON_HEADS


def pooled_page(pooled: PresentedPool, title: str, folders: tuple[str, ...]) -> str:
    """Return the page as self-contained HTML; `folders` beside the page hold the diagnosis of each recording."""

    def drawn(effects: tuple[PresentedEffect, ...]) -> list[tuple[PresentedEffect, Markup]]:
        titles = (f"{one.name} by {pooled.scope.noun}" for one in effects)
        draws = (partial(draw_coefficients, pooled, one) for one in effects)
        return list(zip(effects, map(section.figure_html, draws, titles), strict=True))

    values = {
        "title": title,
        "iron_heads": IRON_HEADS,
        "effects": drawn(pooled.common),
        "alone": drawn(pooled.single),
        "gaps": list(zip(pooled.gaps, (*folders, ""), strict=True)),
        "picture": section.figure_html(partial(draw_gaps, pooled), f"The gap of each {pooled.scope.noun}"),
        "own": list(zip(pooled.names, folders, (one.sentence for one in pooled.each), strict=True)),
    }
    return render_page("pooled.html", vars(pooled) | values)
