"""Page of a comparison: answer, then table and plots of each point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from reports.pages.section import DrawnSection
from reports.pages.template import render_page
from reports.plots.comparison import draw_distributions, draw_over, draw_ranks
from scenarios.arrays import Array
from scenarios.sweep import Value
from validation.comparison.ranking import RankedCalibrator, Ranking, uncorrected_row
from validation.comparison.score_statistics import CLAIMED_INSIDE, CLAIMED_SQUARE, ScoreStatistic, score_statistics
from validation.comparison.statistics import Interval
from validation.comparison.trial_table import TrialTable
from validation.text import counted, digits, figure, plainly, symbol

PERCENT = 100.0


@dataclass(frozen=True)
class SortableCell:
    """Text of a table cell and the number that sorts the column."""

    text: str
    value: float | None = None

    @classmethod
    def of(cls, value: float | None, significant: int = 3) -> SortableCell:
        """Return the cell of a number; a dash for None and non-finite numbers."""
        if value is None or not np.isfinite(value):
            return cls("–")
        return cls(digits(value, significant), value)


@dataclass(frozen=True)
class Comparison:
    """Content of a comparison's page.

    answers: a ranking per point; sentence: the overall answer; reference: calibrator in the denominator of ratios;
    looked_at: where the recorded trials are; least: bound (n,) on scores by trial; keys: point, calibrator and column.
    """

    title: str
    table: TrialTable
    answers: tuple[Ranking, ...]
    sentence: str
    reference: str
    looked_at: str
    least: dict[tuple[int, str, str], Array] = field(default_factory=dict)


def comparison_page(comparison: Comparison, seed: int | None = None) -> str:
    """Return the page as self-contained HTML; seed : of the trials, told beside the title."""
    known = {
        (one.point, one.calibrator, one.score.name): one
        for one in score_statistics(comparison.table, comparison.reference)
    }
    score = comparison.answers[0].score
    return render_page(
        "comparison.html",
        {
            "title": comparison.title,
            "seed": seed,
            "answer": _answer(comparison),
            "figures": _tiles(comparison),
            "summary": _summary(comparison),
            "score": score,
            "reference": comparison.reference,
            "inside": CLAIMED_INSIDE,
            "square": CLAIMED_SQUARE,
            "points": [_point(comparison, point, known) for point in range(len(comparison.answers))],
            "over": list(_over(comparison)),
            "swept": comparison.table.swept,
            "rows": [_figure_row(comparison.table, one) for one in known.values()],
            "scores": list({one.score.name: one.score for one in known.values()}.values()),
            "looked_at": comparison.looked_at,
        },
    )


def _answer(comparison: Comparison) -> str:
    """Return the overall answer; of several points without each point's own, which stands above its table."""
    text = comparison.sentence if len(comparison.answers) == 1 else comparison.sentence.partition(": at ")[0]
    return text.rstrip(".")


def _tiles(comparison: Comparison) -> list[tuple[str, str, str]]:
    first = comparison.answers[0]
    at = f", {point_title(comparison.table.points[0])}" if len(comparison.answers) > 1 else ""
    return [
        (first.best.calibrator, "", f"first by the median{at}"),
        (figure(first.best.median.value), symbol(first.score.unit), first.score.short),
        (f"{first.best.failures} of {first.trials}", "", "its trials that failed"),
        (figure(first.uncorrected.value), symbol(first.score.unit), "without correction"),
    ]


def _summary(comparison: Comparison) -> str:
    candidates, points = (
        counted(len(comparison.table.candidates), "calibrator"),
        counted(len(comparison.answers), "point"),
    )
    trials = counted(comparison.answers[0].trials, "trial")
    swept = f" of {', '.join(comparison.table.swept)}" if comparison.table.swept else ""
    at = f" at {points}{swept}" if len(comparison.answers) > 1 else ""
    return f"{candidates} saw the same {trials}{at}."


def point_title(values: Mapping[str, Value]) -> str:
    """Return a point's swept values as text."""
    texts = {key: plainly(value) if isinstance(value, float) else value for key, value in values.items()}
    return ", ".join(f"{key} = {text}" for key, text in texts.items()) or "all trials"


def _point(comparison: Comparison, point: int, known: dict[tuple[int, str, str], ScoreStatistic]) -> dict[str, Any]:
    answer, table = comparison.answers[point], comparison.table
    rows = [_row(comparison, answer, one, point, known) for one in answer.calibrators]
    return {
        "title": point_title(table.points[point]),
        "sentence": answer.sentence,
        "trials": answer.trials,
        "cost": answer.cost,
        "rows": [*rows, _raw_row(answer)],
        "sections": list(_point_sections(table, answer, point)),
    }


def _row(
    comparison: Comparison,
    answer: Ranking,
    one: RankedCalibrator,
    point: int,
    known: dict[tuple[int, str, str], ScoreStatistic],
) -> dict[str, Any]:
    """Return a calibrator's cells in the order of the template's column heads."""
    name, table = one.calibrator, comparison.table
    entry, inside, square = (
        known.get((point, name, score.name)) for score in (answer.score, CLAIMED_INSIDE, CLAIMED_SQUARE)
    )
    against = None if one is answer.best else answer.against(name)
    cells = [
        *_ends(one.median),
        SortableCell.of(entry.ratio.value if entry and entry.ratio else None),
        SortableCell(str(one.failures), one.failures),
        SortableCell.of(PERCENT * one.failure_rate.high, 2),
        SortableCell("–") if against is None else SortableCell(str(against.better), against.better),
        SortableCell("–") if against is None else SortableCell(figure(against.p, 2), against.p),
        SortableCell.of(PERCENT * inside.found.value if inside else None, 3),
        SortableCell.of(square.found.value if square else None),
        SortableCell.of(1e3 * float(np.nanmedian(table.time_s("cpu_s", name, point))) if table.times else None),
    ]
    return {"name": name, "cells": cells, "reason": _reason(one)}


def _reason(one: RankedCalibrator) -> str:
    """Return how often a calibrator failed, and why most often; empty for none."""
    return f"failed in {counted(one.failures, 'trial')}, most often: {one.reason}" if one.reason else ""


def _raw_row(answer: Ranking) -> dict[str, Any]:
    """Return the row of the uncorrected measurement."""
    rest = [SortableCell("–")] * 8
    name = uncorrected_row(answer.best.calibrator)
    return {"name": name, "cells": [*_ends(answer.uncorrected), *rest], "reason": ""}


def _ends(found: Interval) -> list[SortableCell]:
    return [SortableCell.of(value) for value in (found.value, found.low, found.high)]


def _point_sections(table: TrialTable, answer: Ranking, point: int) -> Iterator[DrawnSection]:
    caption = "5th to 95th percentile of the trials as a line, the middle half as a bar, the median as a dot."
    yield DrawnSection.of("Distributions", caption, partial(draw_distributions, table, answer.score, point))
    if len(table.candidates) > 1:
        caption = "Mean rank over the trials; a bar reaches those whose difference may be chance (Nemenyi)."
        yield DrawnSection.of("Ranks", caption, partial(draw_ranks, table, answer.score, point))


def _over(comparison: Comparison) -> Iterator[DrawnSection]:
    """Yield the score over each swept key."""
    for key in comparison.table.swept:
        name = f"{comparison.answers[0].score.short} over {key}"
        others = [other for other in comparison.table.swept if other != key]
        fixed = f"; {', '.join(others)} as at the first point" if others else ""
        caption = f"Medians with their intervals{fixed}."
        yield DrawnSection.of(
            name[:1].upper() + name[1:], caption, partial(draw_over, comparison.table, comparison.answers[0].score, key)
        )


def _figure_row(table: TrialTable, one: ScoreStatistic) -> dict[str, Any]:
    at = list(table.points[one.point].values())
    return {
        "at": at,
        "name": one.calibrator,
        "score": one.score,
        "unit": symbol(one.score.unit),
        "cells": _ends(one.found),
    }
