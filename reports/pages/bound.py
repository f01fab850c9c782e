"""The page of a bound that is asked about several values: the answer, the table, the pictures."""

from __future__ import annotations

from functools import partial

from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.bound import draw_offset, draw_score_bounds
from validation.bound.query import WhatIf
from validation.bound.summary import headline, what_if_headline, what_if_heads, what_if_rows
from validation.text import short

PICTURES = (
    ("The offset", "The least standard deviation that any method can reach; where a line breaks off, nothing is told.",
     draw_offset),
    ("What it is used for", "The least average of each score of a calibration at the bound.", draw_score_bounds),
)  # fmt: skip


def bound_page(found: WhatIf, title: str) -> str:
    """The page as HTML; all of it is inside."""
    values = zip(found.values, found.answers, strict=True)
    return render_page(
        "bound.html",
        {
            "title": title,
            "sentence": what_if_headline(found),
            "heads": what_if_heads(found),
            "rows": what_if_rows(found),
            "pictures": [(name, caption, figure_html(partial(draw, found), name)) for name, caption, draw in PICTURES],
            "points": [(f"{found.key} = {short(value)}", headline(one).splitlines()) for value, one in values],
        },
    )
