"""Pages of a bound, and of a bound over the values of a key: answer, tables, plots."""

from __future__ import annotations

from collections.abc import Sequence

from reports.pages.section import DrawnSection, Section, drawn_sections
from reports.pages.template import render_page
from reports.plots.bound import draw_components, draw_offset, draw_score_bounds
from validation.bound.query import BoundAnswer, WhatIf
from validation.bound.summary import (
    HEADS,
    SCORE_HEADS,
    Row,
    headline,
    rows,
    score_rows,
    what_if_headline,
    what_if_heads,
    what_if_rows,
)
from validation.text import given

SECTIONS = (
    Section("Offset",
            "Least standard deviation that any method can reach. A line ends where the offset is not observable.",
            draw_offset),
    Section("Scores", "Least mean of each score of a calibration that reaches the bound.", draw_score_bounds),
)  # fmt: skip


COMPONENTS = Section(
    "Offset by axis", "Least standard deviation that any method can reach; no bar: not observable.", draw_components
)


def bound_page(found: BoundAnswer, title: str) -> str:
    """Return the page of a bound as self-contained HTML."""
    tables = [(HEADS, rows(found)), (SCORE_HEADS, score_rows(found.used))]
    sections = drawn_sections((COMPONENTS,), found)
    return _rendered(title, headline(found).splitlines(), tables, sections, [])


def what_if_page(what_if: WhatIf, title: str) -> str:
    """Return the page of a bound over the values of a key as self-contained HTML."""
    values = zip(what_if.values, what_if.answers, strict=True)
    points = [(f"{what_if.key} = {given(value)}", headline(one).splitlines()) for value, one in values]
    tables = [(what_if_heads(what_if), what_if_rows(what_if))]
    return _rendered(title, [what_if_headline(what_if)], tables, drawn_sections(SECTIONS, what_if), points)


def _rendered(
    title: str,
    sentences: Sequence[str],
    tables: Sequence[tuple[Row, Sequence[Row]]],
    sections: Sequence[DrawnSection],
    points: Sequence[tuple[str, Sequence[str]]],
) -> str:
    values = {"title": title, "sentences": sentences, "tables": tables, "sections": sections, "points": points}
    return render_page("bound.html", values)
