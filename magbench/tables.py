"""Results as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from calib.result import Calibration
from diagnosis.repair.model_diff import lines_of_diff, model_diff
from diagnosis.result import Diagnosis
from diagnosis.several.result import PooledDiagnosis
from magbench.console import show_table, show_text
from reports.pages.comparison import Comparison, point_title
from reports.text.diagnosis import PART_HEADS, gap_rows, parameter_rows, part_rows
from reports.text.diagnosis import headline as diagnosis_headline
from reports.text.outcome import headline
from reports.text.pooled import agreement_line, coefficient_rows, pooled_gap_rows
from validation.comparison.ranking import uncorrected_row
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

MOST_DIFF_LINES = 40


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
            ends = (short(v) for v in (one.median.value, one.median.low, one.median.high))
            better = "" if one is answer.best else str(answer.against(one.calibrator).better)
            rows.append([one.calibrator, *ends, str(one.failures), better])
        ends = (short(v) for v in (answer.uncorrected.value, answer.uncorrected.low, answer.uncorrected.high))
        rows.append([uncorrected_row(answer.best.calibrator), *ends, "", ""])
        show_table(f"{found.title}: {point_title(found.table.points[point])}", heads, rows)


def show_calibrations(calibrations: Mapping[str, Calibration]) -> None:
    """Offset, matrix and status of each calibration; dashes without an estimate."""
    rows = []
    for name, c in calibrations.items():
        offset, matrix = "-", "-"
        if c.has_estimate:
            offset = " ".join(f"{v:.2f}" for v in c.offset_nT)
            matrix = "; ".join(" ".join(f"{v:.5f}" for v in row) for row in c.matrix)
        rows.append([name, c.status.kind, offset, matrix, c.status.reason])
    show_table("calibrations", ["calibrator", "status", "offset, nT", "matrix", "reason"], rows)


def show_answer(found: Diagnosis | PooledDiagnosis) -> None:
    """A diagnosis of one or of several recordings."""
    if isinstance(found, Diagnosis):
        show_diagnosis(found)
    else:
        show_together(found)


def show_together(found: PooledDiagnosis) -> None:
    """Verdict, sentence, next steps, each effect by recording, the gaps, and the change of the model."""
    show_text(diagnosis_headline(found) + "\n")
    for one in found.common:
        heads = [found.scope.noun, "", "parameter", "value", "low", "high", "unit"]
        show_table(
            f"{one.name}: {found.scope.labels[one.transfer]}", heads, list(coefficient_rows(found, one)), numbers=False
        )
        show_text(agreement_line(one) + "\n")
    heads = ["gap, rms", "before, nT", "after, nT", "before / noise", "after / noise", "explained", "by itself"]
    show_table("", heads, pooled_gap_rows(found))
    diff = lines_of_diff(found.each[0].problem.effects, found.model)
    if 0 < len(diff) <= MOST_DIFF_LINES:
        show_text("\n" + "\n".join(diff))


def show_diagnosis(found: Diagnosis) -> None:
    """Verdict, sentence, next steps, effects, gap, and the change of the model where it is short."""
    show_text(diagnosis_headline(found) + "\n")
    heads = ["effect", "or", "parameter", "value", "low", "high", "unit"]
    rows = [
        [one.name, ", ".join(one.alternatives), *(cell or "" for cell in row)]
        for one in found.named
        for row in parameter_rows(one)
    ]
    if rows:
        show_table("missing effects", heads, rows, numbers=False)
    heads = ["gap, rms", "before, nT", "after, nT", "before / noise", "after / noise", "explained"]
    show_table("", heads, gap_rows(found))
    if parts := part_rows(found):
        show_table("when it is", PART_HEADS, parts)
    diff = model_diff(found)
    if 0 < len(diff) <= MOST_DIFF_LINES:
        show_text("\n" + "\n".join(diff))
