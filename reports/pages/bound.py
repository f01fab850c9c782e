"""Page of a bound swept over the values of a key: answer, table, plots."""

from __future__ import annotations

from reports.pages.section import Section, drawn_sections
from reports.pages.template import render_page
from reports.plots.bound import draw_offset, draw_score_bounds
from validation.bound.query import WhatIf
from validation.bound.summary import headline, what_if_headline, what_if_heads, what_if_rows
from validation.text import short

SECTIONS = (
    Section("Offset",
            "Least standard deviation that any method can reach. A line ends where the offset is not observable.",
            draw_offset),
    Section("Scores", "Least mean of each score of a calibration that reaches the bound.", draw_score_bounds),
)  # fmt: skip


def bound_page(what_if: WhatIf, title: str) -> str:
    """Return the page as self-contained HTML."""
    values = zip(what_if.values, what_if.answers, strict=True)
    return render_page(
        "bound.html",
        {
            "title": title,
            "sentence": what_if_headline(what_if),
            "heads": what_if_heads(what_if),
            "rows": what_if_rows(what_if),
            "sections": drawn_sections(SECTIONS, what_if),
            "points": [(f"{what_if.key} = {short(value)}", headline(one).splitlines()) for value, one in values],
        },
    )
