"""Results as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from calib.models.scalar_terms import NAMES
from calib.result import Calibration
from magbench.console import show_table, show_text
from reports.pages.comparison import Comparison, point_title
from reports.presentation.diagnosis import GAP_HEADS, PARAMETER_HEADS, PART_HEADS, PresentedDiagnosis, cells
from reports.presentation.pooled import PresentedPool
from reports.presentation.stated_iron import IRON_HEADS
from reports.text.outcome import headline
from validation.calibrating.output_unit import OutputUnit
from validation.comparison.ranking import uncorrected_row
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.outcome import Outcome
from validation.text import figure, short, symbol

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


def show_calibrations(calibrations: Mapping[str, Calibration]) -> None:
    """Offset, matrix and status of each calibration, dashes without an estimate; then the reasons."""
    rows = [[name, c.status.kind, *_offset_and_matrix(c)] for name, c in calibrations.items()]
    show_table("calibrations", ["calibrator", "status", "offset, nT", "matrix"], rows)
    for name, c in calibrations.items():
        if c.status.reason:
            show_text(f"{name}: {c.status.reason}")
    for name, c in calibrations.items():
        if c.corrects_scalar:
            title = f"{name}: the vehicle's field at the scalar magnetometer"
            show_table(title, ["term", "value", "standard deviation", "unit"], scalar_term_rows(c))


def _offset_and_matrix(fit: Calibration) -> tuple[str, str]:
    """The cells of an estimate, a line each axis; a dash without an estimate, and for z where it is not determined."""
    if not fit.has_estimate:
        return "-", "-"
    offset = [f"{value:.2f}" for value in fit.offset_nT]
    matrix = "\n".join(" ".join(f"{value:8.5f}" for value in row) for row in fit.matrix)
    return "\n".join(offset if fit.determines_z else [*offset[:2], "-"]), matrix


def show_in_unit(calibrations: Mapping[str, Calibration], unit: OutputUnit) -> None:
    """Offset and matrix of each estimate in a unit."""
    rows = []
    for name, c in calibrations.items():
        if c.has_estimate:
            matrix = "; ".join(" ".join(f"{v:.6g}" for v in row) for row in unit.matrix(c))
            rows.append([name, " ".join(f"{v:.6g}" for v in unit.offset(c)), matrix])
    show_table(unit.model, ["calibrator", f"offset, {unit.measured}", "matrix"], rows)


def scalar_term_rows(fit: Calibration) -> list[list[str]]:
    """A row a Tolles-Lawson term, with its standard deviation, and the strength's rms before and after."""
    std = {} if fit.covariance is None else dict(zip(fit.covariance_names, np.diag(fit.covariance) ** 0.5, strict=True))
    units = {"nT": "nT", "s": "s"}
    known = [name for name in NAMES if name in fit.parameters]
    cells = [(name, fit.parameters[name], std.get(name), units.get(name.split("_")[-1], "")) for name in known]
    rows = [[name, figure(value), "-" if wide is None else figure(wide), unit] for name, value, wide, unit in cells]
    rms = (("raw_rms_nT", "held-out strength, raw"), ("held_out_rms_nT", "held-out strength, compensated"))
    return rows + [[words, figure(fit.parameters[key]), "", "nT"] for key, words in rms if key in fit.parameters]


def show_answer(found: PresentedDiagnosis | PresentedPool) -> None:
    """A diagnosis of one or of several recordings: words, tables, and the change of the model where it is short."""
    show_text(found.headline + "\n")
    if found.stated:
        iron = [row for one in found.stated for row in one.rows]
        show_table("the stated calibration against each recording", IRON_HEADS, iron, numbers=False)
    if isinstance(found, PresentedPool):
        _show_together(found)
    else:
        _show_diagnosis(found)
    if 0 < len(found.diff) <= MOST_DIFF_LINES:
        show_text("\n" + "\n".join(found.diff))


def _show_together(found: PresentedPool) -> None:
    """Each effect by recording, and the gaps."""
    for one in found.common:
        show_table(f"{one.name}: {one.reach}", [found.scope.noun, "", *PARAMETER_HEADS], one.rows, numbers=False)
        show_text(one.test + "\n")
    show_table("", [*GAP_HEADS, "by itself"], found.gaps)


def _show_diagnosis(found: PresentedDiagnosis) -> None:
    """Effects, gap, and the parts of the run."""
    rows = [(one.name, ", ".join(one.alternatives), *cells(row)) for one in found.causes for row in one.parameters]
    if rows:
        show_table("missing effects", ["effect", "or", *PARAMETER_HEADS], rows, numbers=False)
    show_table("", GAP_HEADS, found.gaps)
    if found.parts:
        show_table("when it is", PART_HEADS, found.parts)
