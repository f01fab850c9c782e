"""An outcome in words and numbers: what the report's text and the recording's notes share."""

from __future__ import annotations

from typing import Any

import numpy as np

from calib import Calibration
from sim.tracking import warning
from sim.vehicles import VEHICLES
from validation.scoring.outcome import Array, Outcome
from validation.scoring.scores import Score
from validation.text import digits, plainly, words

CALIBRATORS_A_TABLE = 4
ALIGNED = "† after the rotation that the field's strength alone cannot tell was taken out."
STATUS_WORDS = {
    "ok": "ok", "not_converged": "not converged", "unobservable": "unobservable", "not_applicable": "not applicable",
}  # fmt: skip


def rms_length(values: Array) -> float:
    """Root mean square of the finite values (n,); of vectors (n, 3), of their lengths."""
    square = values**2 if values.ndim == 1 else np.sum(values**2, axis=1)
    finite = square[np.isfinite(square)]
    return float(np.sqrt(np.mean(finite))) if finite.size else float("nan")


def duration_s(outcome: Outcome) -> float:
    """Length of the recording."""
    return float(outcome.recording.time_s[-1] - outcome.recording.time_s[0])


def what_was_simulated(outcome: Outcome) -> str:
    """The scenario in a few sentences."""
    scenario, field = outcome.scenario, outcome.scenario.field
    phases = ", ".join(dict.fromkeys(words(label) for label, _, _ in outcome.phases()))
    place = (
        f"a given field of {', '.join(plainly(v) for v in field.enu_nT)} nT (east, north, up)"
        if field.enu_nT is not None
        else f"the IGRF-14 field at {field.latitude_deg:g}° latitude, {field.longitude_deg:g}° longitude, {field.date},"
    )
    sensors = "one three-axis magnetometer" if outcome.sensors == 1 else f"{outcome.sensors} three-axis magnetometers"
    names = [words(name) for name in outcome.effects]
    injected = f"Effects injected ({len(names)}): {', '.join(names)}." if names else "No effect was injected."
    moved, length = VEHICLES[scenario.vehicle.kind].noun, plainly(round(duration_s(outcome), 1))
    return (
        f"{moved[0].upper()}{moved[1:]} moved through {phases} in {place} for {length} s, "
        f"carrying {sensors} sampled at {scenario.sampling.rate_hz:g} Hz. {injected}"
    )


SHOWN_ELSEWHERE = ("failure", "wall_time")
"""Scores that the table's own columns already say."""


def score_table(outcome: Outcome) -> dict[str, Any]:
    """Calibrators x scores: best first; in-sample scores last, as they rank nothing.

    heads: name, unit, in_sample, ranks (orders the rows); rows: name, kind, status, reason, wall_s, cells;
    by: the ordering score in words; aligned: whether a cell carries the mark of a removed rotation.
    """
    columns = {s.name: s for scores in outcome.scores.values() for s in scores if s.name not in SHOWN_ELSEWHERE}
    ordered = sorted(columns.values(), key=lambda s: s.in_sample)
    by = outcome.ranking()[1]
    rows = []
    for name in outcome.rows():
        scores = {s.name: s for s in outcome.scores.get(name, [])}
        cells = [_cell(scores.get(s.name)) for s in ordered]
        rows.append({"name": name, **_fit_in_words(outcome.calibrations.get(name)), "cells": cells})
    heads = [{"name": words(s.name), "unit": s.unit, "in_sample": s.in_sample, "ranks": s.name == by} for s in ordered]
    aligned = any(s.rotation_removed for scores in outcome.scores.values() for s in scores)
    return {"heads": heads, "rows": rows, "by": words(by), "aligned": aligned}


def _fit_in_words(calibration: Calibration | None) -> dict[str, str]:
    """Status, reason and time of a fit; of the raw measurement, which is none, dashes."""
    if calibration is None:
        return {"kind": "", "status": "–", "reason": "", "wall_s": "–"}
    status, wall_s = calibration.status, digits(calibration.wall_s, 2)
    return {"kind": status.kind, "status": STATUS_WORDS[status.kind], "reason": status.reason, "wall_s": wall_s}


def _cell(score: Score | None) -> str:
    if score is None:
        return "–"
    counted = not score.unit and float(score.value).is_integer()
    return (plainly(score.value) if counted else digits(score.value)) + ("†" if score.rotation_removed else "")


def notes_markdown(outcome: Outcome) -> str:
    """What was simulated and how each calibrator did, as Markdown: a column a calibrator, a few to a table."""
    table = score_table(outcome)
    lines = [f"# {outcome.scenario.name}", "", outcome.scenario.summary, "", what_was_simulated(outcome)]
    if astray := warning([outcome.tracking]):
        lines += ["", f"**Beware: {astray}.**"]
    if outcome.sensors > 1:
        lines += ["", f"Of the {outcome.sensors} magnetometers this recording shows sensor 1."]
    for first in range(0, len(table["rows"]), CALIBRATORS_A_TABLE):
        lines += ["", *_columns(table["heads"], table["rows"][first : first + CALIBRATORS_A_TABLE])]
    lines += ["", *(f"- **{row['name']}**: {_one_line(row['reason'])}" for row in table["rows"] if row["reason"])]
    lines += ["", "In-sample scores rank nothing." + (" " + ALIGNED if table["aligned"] else "")]
    return "\n".join([*lines, "", f"Seed {outcome.scenario.seed}."]) + "\n"


def _columns(heads: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[str]:
    """Lines of a table with a column for each of these calibrators."""
    names = [f"{h['name']} ({h['unit'] or '–'}{', in-sample' if h['in_sample'] else ''})" for h in heads]
    cells = [_row([name, *(row["cells"][k] for row in rows)]) for k, name in enumerate(names)]
    top = [_row(["", *(row["name"] for row in rows)]), _row(["---"] * (1 + len(rows)))]
    return [*top, _row(["status", *(row["status"] for row in rows)]), *cells]


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(_one_line(cell).replace("|", "\\|") for cell in cells) + " |"


def _one_line(text: str) -> str:
    return " ".join(text.split())
