"""Results as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from calib.result import Calibration
from magbench.console import show_table
from validation.diagnosis.result import Diagnosis, parameters, short
from validation.outcome import Outcome

COLUMNS = {
    "offset_error": "offset",
    "holdout_sphere_component_rms": "all attitudes",
    "holdout_level_component_rms": "level survey",
    "heading_rms": "heading",
    "anomaly_rms": "anomaly",
}
"""The scores that fit a terminal, and their short titles; all of them are in the report and in scores.json."""


def show_scores(outcome: Outcome) -> None:
    """A row a calibrator, best first."""
    order, ranked_by = outcome.ranking()
    units = {s.name: s.unit for scores in outcome.scores.values() for s in scores}
    rows = []
    for calibrator in order:
        values = {s.name: s.value for s in outcome.scores[calibrator]}
        figures = (f"{values[name]:.4g}" if name in values else "-" for name in COLUMNS)
        rows.append([calibrator, *figures, outcome.calibrations[calibrator].status.kind])
    titles = (f"{title}, {units.get(name, 'nT')}" for name, title in COLUMNS.items())
    title = f"{outcome.scenario.name}: errors against truth, best first by {ranked_by.replace('_', ' ')}"
    show_table(title, ["calibrator", *titles, "status"], rows)


def show_calibrations(calibrations: Mapping[str, Calibration]) -> None:
    """Offset, matrix and status of each calibration."""
    rows = []
    for name, c in calibrations.items():
        matrix = "; ".join(" ".join(f"{v:.5f}" for v in row) for row in c.matrix)
        rows.append([name, c.status.kind, " ".join(f"{v:.2f}" for v in c.offset_nT), matrix, c.status.reason])
    show_table("calibrations", ["calibrator", "status", "offset, nT", "matrix", "reason"], rows)


def show_diagnosis(found: Diagnosis) -> None:
    """Verdict, sentence, effects with parameters, gap and advice."""
    show_table("", [f"verdict: {found.verdict}"], [[found.sentence]], numbers=False)
    rows = [
        [one.name, ", ".join(one.alternatives), name, *(short(p[key]) for key in ("value", "low", "high")), p["unit"]]
        for one in found.named
        for name, p in parameters(one).items()
        if p["low"] is not None or p["value"] not in (0, 0.0)
    ]
    if rows:
        show_table(
            "missing effects", ["effect", "or", "parameter", "value", "low", "high", "unit"], rows, numbers=False
        )
    gap = found.gap
    share = "" if gap.explained is None else f"{100 * gap.explained:.1f} %"
    sizes = [
        f"{gap.before_nT:.4g} nT",
        f"{gap.after_nT:.4g} nT",
        f"{gap.before_sigma:.4g}",
        f"{gap.after_sigma:.4g}",
        share,
    ]
    show_table("gap, held out", ["before", "after", "before / noise", "after / noise", "explained"], [sizes])
    if found.advice:
        show_table("", ["what to do next"], [[line] for line in found.advice], numbers=False)
