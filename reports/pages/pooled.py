"""Page of a pooled diagnosis: effects common to all recordings, coefficients by recording, gap of each recording."""

from __future__ import annotations

from functools import partial
from typing import Any

from diagnosis.repair.model_diff import lines_of_diff
from diagnosis.result import Transfer
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.sentence import describe_transfer
from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.pooled import draw_coefficients, draw_gaps
from reports.text.pooled import agreement_line, coefficient_rows, pooled_gap_rows
from scenarios.toml import to_toml
from validation.text import all_of, digits


def pooled_page(pooled: PooledDiagnosis, title: str, folders: tuple[str, ...]) -> str:
    """Return the page as self-contained HTML; `folders` beside the page hold the diagnosis of each recording."""
    return render_page("pooled.html", _page(pooled, title, folders))


def _page(pooled: PooledDiagnosis, title: str, folders: tuple[str, ...]) -> dict[str, Any]:
    first = pooled.each[0].problem
    return {
        "title": title,
        "among": pooled.scope,
        "verdict": pooled.verdict,
        "meaning": pooled.verdict.meaning,
        "sentence": pooled.sentence,
        "tiles": _tiles(pooled),
        "advice": pooled.advice,
        "effects": [_section(pooled, one) for one in pooled.common],
        "single": [_section(pooled, one) for one in pooled.single],
        "gaps": list(zip(pooled_gap_rows(pooled), (*folders, ""), strict=True)),
        "picture": figure_html(partial(draw_gaps, pooled), f"The gap of each {pooled.scope.noun}"),
        "own": list(zip(pooled.names, folders, (one.sentence for one in pooled.each), strict=True)),
        "left": pooled.unexplained,
        "where": pooled.where,
        "not_observable": pooled.not_observable,
        "diff": lines_of_diff(first.effects, pooled.model),
        "model": to_toml(pooled.model),
    }


def _section(pooled: PooledDiagnosis, one: CommonEffect) -> dict[str, Any]:
    return {
        "name": one.name,
        "reach": pooled.scope.labels[one.transfer],
        "bad": one.transfer is not Transfer.TRANSFERRED,
        "words": describe_transfer(one, pooled.scope),
        "alternatives": one.named.look_alikes,
        "test": agreement_line(one),
        "how": one.named.kind.words,
        "nats": "" if one.named.nats is None else f"{digits(one.named.nats)} nats",
        "rows": list(coefficient_rows(pooled, one)),
        "picture": figure_html(partial(draw_coefficients, pooled, one), f"{one.name} by {pooled.scope.noun}"),
    }


def _tiles(pooled: PooledDiagnosis) -> list[tuple[str, str]]:
    """Return the answer in four tiles (value, label)."""
    by_reach = {transfer: [one.name for one in pooled.common if one.transfer is transfer] for transfer in Transfer}
    same = ", ".join(by_reach[Transfer.TRANSFERRED]) or "nothing"
    differs = ", ".join([*by_reach[Transfer.NOT_TRANSFERRED], *by_reach[Transfer.SOME]]) or "nothing"
    gap = pooled.gap
    share = "–" if gap.explained is None else f"{100 * max(gap.explained, 0):.0f} %"
    alone = ", ".join(one.name for one in pooled.single) or "nothing"
    return [
        (same, f"missing in the model, equal in {all_of(len(pooled.names), pooled.scope.key)}"),
        (differs, "missing, but not equal in all"),
        (alone, f"cause in one {pooled.scope.noun} only"),
        (share, f"of the gap explained: {digits(gap.before_nT)} → {digits(gap.after_nT)} nT, {pooled.scope.after}"),
    ]
