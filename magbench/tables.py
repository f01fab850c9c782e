"""Results as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from calib.result import Calibration
from magbench.console import show_table
from validation.outcome import Outcome


def show_scores(outcome: Outcome) -> None:
    """Calibrators by score, best first; in-sample figures are marked and rank nothing."""
    order, ranked_by = outcome.ranking()
    names = list(dict.fromkeys(score.name for scores in outcome.scores.values() for score in scores))
    scores = {c: {s.name: s for s in outcome.scores[c]} for c in order}
    rows = []
    for name in names:
        some = next(s[name] for s in scores.values() if name in s)
        title = name.replace("_", " ") + (f", {some.unit}" if some.unit else "")
        rows.append([title, *(f"{scores[c][name].value:.4g}" if name in scores[c] else "-" for c in order)])
    rows.append(["status", *(outcome.calibrations[c].status.kind for c in order)])
    show_table(f"{outcome.scenario.name}: scores, best first by {ranked_by.replace('_', ' ')}", ["score", *order], rows)


def show_calibrations(calibrations: Mapping[str, Calibration]) -> None:
    """Offset, matrix and status of each calibration."""
    rows = []
    for name, c in calibrations.items():
        matrix = "; ".join(" ".join(f"{v:.5f}" for v in row) for row in c.matrix)
        rows.append([name, c.status.kind, " ".join(f"{v:.2f}" for v in c.offset_nT), matrix, c.status.reason])
    show_table("calibrations", ["calibrator", "status", "offset, nT", "matrix", "reason"], rows)
