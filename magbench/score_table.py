"""Scores of a run as a table for the terminal."""

from __future__ import annotations

from magbench.console import show_table, show_text
from reports.text.outcome import headline
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.outcome import Outcome
from validation.text import short, symbol

COLUMNS = (
    "holdout_level_component_rms",
    "holdout_sphere_component_rms",
    "heading_rms",
    "anomaly_rms",
    "offset_error",
)
"""The scores that fit a terminal; all of them are in the report and in scores.json."""


def show_scores(outcome: Outcome) -> None:
    """The answer, then a row a calibrator, best first, and the raw measurement's last."""
    show_text(headline(outcome) + "\n")
    rows = []
    for calibrator in outcome.rows():
        values = {s.name: s.value for s in outcome.scores[calibrator]}
        figures = (short(values[name]) if name in values else "-" for name in COLUMNS)
        fitted = outcome.calibrations.get(calibrator)
        rows.append([calibrator, *figures, fitted.status.kind if fitted else "-"])
    shown = [SCORE_DEFINITIONS[name] for name in COLUMNS]
    heads = [f"{one.short}, {symbol(one.unit)}" for one in shown]
    ranked_by = outcome.ranking()[1]
    order = f", best first by {SCORE_DEFINITIONS[ranked_by].short}" if ranked_by else ""
    show_table(f"{outcome.scenario.name}: errors against truth{order}", ["calibrator", *heads, "status"], rows)
    show_text("\n".join(f"{one.short}: {one.explained}" for one in shown))
