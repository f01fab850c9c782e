"""The report of a comparison: the answer first, then each point's table and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from markupsafe import Markup

from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.comparison import draw_distributions, draw_over, draw_ranks
from scenarios.arrays import Array
from scenarios.sweep import Value
from validation.comparison.ranking import RankedCalibrator, Ranking, uncorrected_row
from validation.comparison.score_statistics import CLAIMED_INSIDE, CLAIMED_SQUARE, ScoreStatistic, score_statistics
from validation.comparison.statistics import Interval
from validation.comparison.trial_table import TrialTable
from validation.text import counted, digits, figure, plainly

PERCENT = 100.0


@dataclass(frozen=True)
class SortableCell:
    """What a cell of a table shows, and the number that it sorts by."""

    text: str
    value: float | None = None

    @classmethod
    def of(cls, value: float | None, significant: int = 3) -> SortableCell:
        """A number; a dash for what is not known or not finite."""
        if value is None or not np.isfinite(value):
            return cls("–")
        return cls(digits(value, significant), value)


@dataclass(frozen=True)
class Comparison:
    """What a page shows: the table, an answer a point, the sentence of all, and where the trials to look at are.

    least: the bound (n,) on scores in each trial, by point, calibrator and column.
    """

    title: str
    table: TrialTable
    answers: tuple[Ranking, ...]
    sentence: str
    reference: str
    looked_at: str
    least: dict[tuple[int, str, str], Array] = field(default_factory=dict)


def comparison_page(found: Comparison) -> str:
    """The page as HTML; all of it is inside."""
    known = {(one.point, one.calibrator, one.score.name): one for one in score_statistics(found.table, found.reference)}
    score = found.answers[0].score
    return render_page(
        "comparison.html",
        {
            "title": found.title,
            "sentence": found.sentence,
            "tiles": _tiles(found),
            "summary": _summary(found),
            "score": score,
            "reference": found.reference,
            "inside": CLAIMED_INSIDE,
            "square": CLAIMED_SQUARE,
            "points": [_point(found, point, known) for point in range(len(found.answers))],
            "over": list(_over(found)),
            "swept": found.table.swept,
            "figures": [_figure_row(found.table, one) for one in known.values()],
            "scores": list({one.score.name: one.score for one in known.values()}.values()),
            "looked_at": found.looked_at,
        },
    )


def _tiles(found: Comparison) -> list[tuple[str, str, str]]:
    first = found.answers[0]
    return [
        (first.best.calibrator, "", "first by the median"),
        (figure(first.best.median.value), first.score.unit, first.score.short),
        (f"{first.best.failures} of {first.trials}", "", "its trials that failed"),
        (figure(first.uncorrected.value), first.score.unit, "without correction"),
    ]


def _summary(found: Comparison) -> str:
    candidates, points = counted(len(found.table.candidates), "calibrator"), counted(len(found.answers), "point")
    trials = counted(found.answers[0].trials, "trial")
    swept = f" of {', '.join(found.table.swept)}" if found.table.swept else ""
    return f"{candidates} saw the same {trials} at {points}{swept}."


def point_title(values: Mapping[str, Value]) -> str:
    """A point's swept values in words."""
    texts = {key: plainly(value) if isinstance(value, float) else value for key, value in values.items()}
    return ", ".join(f"{key} = {text}" for key, text in texts.items()) or "all trials"


def _point(found: Comparison, point: int, known: dict[tuple[int, str, str], ScoreStatistic]) -> dict[str, Any]:
    answer, table = found.answers[point], found.table
    rows = [_row(found, answer, one, point, known) for one in answer.calibrators]
    return {
        "title": point_title(table.points[point]),
        "sentence": answer.sentence,
        "trials": answer.trials,
        "rows": [*rows, _raw_row(answer)],
        "pictures": list(_pictures(table, answer, point)),
    }


def _row(
    found: Comparison,
    answer: Ranking,
    one: RankedCalibrator,
    point: int,
    known: dict[tuple[int, str, str], ScoreStatistic],
) -> dict[str, Any]:
    """A calibrator's cells, in the order of the template's heads."""
    name, table = one.calibrator, found.table
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
    return {"name": name, "cells": cells, "reason": one.reason}


def _raw_row(answer: Ranking) -> dict[str, Any]:
    """The measurement as it is."""
    rest = [SortableCell("–")] * 8
    name = uncorrected_row(answer.best.calibrator)
    return {"name": name, "cells": [*_ends(answer.uncorrected), *rest], "reason": ""}


def _ends(found: Interval) -> list[SortableCell]:
    return [SortableCell.of(value) for value in (found.value, found.low, found.high)]


def _pictures(table: TrialTable, answer: Ranking, point: int) -> Iterator[tuple[str, str, Markup]]:
    name = "Distributions"
    caption = "5th to 95th percentile of the trials as a line, the middle half as a bar, the median as a dot."
    yield name, caption, figure_html(partial(draw_distributions, table, answer.score, point), name)
    if len(table.candidates) > 1:
        name = "Ranks"
        caption = "Mean rank over the trials; a bar reaches those whose difference may be chance (Nemenyi)."
        yield name, caption, figure_html(partial(draw_ranks, table, answer.score, point), name)


def _over(found: Comparison) -> Iterator[tuple[str, str, Markup]]:
    """A picture a swept key."""
    for key in found.table.swept:
        name = f"{found.answers[0].score.short} over {key}"
        others = [other for other in found.table.swept if other != key]
        fixed = f"; {', '.join(others)} as at the first point" if others else ""
        caption = f"Medians with their intervals{fixed}."
        yield name, caption, figure_html(partial(draw_over, found.table, found.answers[0].score, key), name)


def _figure_row(table: TrialTable, one: ScoreStatistic) -> dict[str, Any]:
    at = list(table.points[one.point].values())
    return {"at": at, "name": one.calibrator, "score": one.score, "cells": _ends(one.found)}
