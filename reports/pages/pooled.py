"""The page of several recordings: what holds in all of them, each effect's coefficients, then each recording's gap."""

from __future__ import annotations

from functools import partial
from typing import Any

from diagnosis.repair.model_diff import lines_of_diff
from diagnosis.result import Transfer
from diagnosis.several.common_effects import Common
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.sentence import reach_of
from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.pooled import draw_coefficients, draw_gaps
from reports.text.pooled import agreement_line, coefficient_rows, pooled_gap_rows
from scenarios.toml import to_toml
from validation.text import all_of, digits


def pooled_page(found: PooledDiagnosis, title: str, folders: tuple[str, ...]) -> str:
    """The report as one HTML text; `folders` are those beside it that hold each recording's own."""
    return render_page("pooled.html", _page(found, title, folders))


def _page(found: PooledDiagnosis, title: str, folders: tuple[str, ...]) -> dict[str, Any]:
    first = found.each[0].problem
    return {
        "title": title,
        "among": found.among,
        "verdict": found.verdict,
        "meaning": found.verdict.meaning,
        "sentence": found.sentence,
        "tiles": _tiles(found),
        "advice": found.advice,
        "effects": [_section(found, one) for one in found.common],
        "single": [_section(found, one) for one in found.single],
        "gaps": list(zip(pooled_gap_rows(found), (*folders, ""), strict=True)),
        "picture": figure_html(partial(draw_gaps, found), f"The gap of each {found.among.one}"),
        "own": list(zip(found.names, folders, (one.sentence for one in found.each), strict=True)),
        "left": found.left,
        "where": found.where,
        "not_observable": found.not_observable,
        "diff": lines_of_diff(first.effects, found.model),
        "model": to_toml(found.model),
    }


def _section(found: PooledDiagnosis, one: Common) -> dict[str, Any]:
    return {
        "name": one.name,
        "reach": found.among.reach[one.reach],
        "bad": one.reach is not Transfer.TRANSFERRED,
        "words": reach_of(one, found.among),
        "alternatives": one.named.others,
        "test": agreement_line(one),
        "how": one.named.how.words,
        "nats": "" if one.named.nats is None else f"{digits(one.named.nats)} nats",
        "rows": list(coefficient_rows(found, one)),
        "picture": figure_html(partial(draw_coefficients, found, one), f"{one.name} by {found.among.one}"),
    }


def _tiles(found: PooledDiagnosis) -> list[tuple[str, str]]:
    """The answer in four tiles: (value, label)."""
    by_reach = {reach: [one.name for one in found.common if one.reach is reach] for reach in Transfer}
    same = ", ".join(by_reach[Transfer.TRANSFERRED]) or "nothing"
    differs = ", ".join([*by_reach[Transfer.NOT_TRANSFERRED], *by_reach[Transfer.SOME]]) or "nothing"
    gap = found.gap
    share = "–" if gap.explained is None else f"{100 * max(gap.explained, 0):.0f} %"
    alone = ", ".join(one.name for one in found.single) or "nothing"
    return [
        (same, f"missing in the model, the same in {all_of(len(found.names), found.among.key)}"),
        (differs, "missing, but not the same in all"),
        (alone, f"named by one {found.among.one} alone"),
        (share, f"of the gap explained: {digits(gap.before_nT)} → {digits(gap.after_nT)} nT, {found.among.after}"),
    ]
