"""A comparison as tables for the terminal."""

from __future__ import annotations

import numpy as np

from magbench.console import show_table, show_text
from reports.pages.comparison import Comparison, point_title
from validation.comparison.ranking import uncorrected_row
from validation.text import short


def show_comparison(found: Comparison) -> None:
    """The answer, and at each point a row a calibrator, best first."""
    show_text(found.sentence + "\n")
    for point, answer in enumerate(found.answers):
        unit = f", {answer.score.unit}" if answer.score.unit else ""
        heads = [
            "calibrator",
            f"{answer.score.short}{unit}",
            "low",
            "high",
            "failed",
            f"first better, of {answer.trials}",
        ]
        rows = []
        for one in answer.calibrators:
            ends = (short(v) if v < np.inf else "-" for v in (one.median.value, one.median.low, one.median.high))
            better = "" if one is answer.best else str(answer.against(one.calibrator).better)
            rows.append([one.calibrator, *ends, str(one.failures), better])
        ends = (short(v) for v in (answer.uncorrected.value, answer.uncorrected.low, answer.uncorrected.high))
        rows.append([uncorrected_row(answer.best.calibrator), *ends, "", ""])
        show_table(f"{found.title}: {point_title(found.table.points[point])}", heads, rows)
        for one in answer.calibrators:
            if one.reason:
                show_text(f"{one.calibrator} failed in {one.failures} of {answer.trials}: {one.reason}")
    show_text(found.answers[0].cost + "\n")
