"""Sentences and table rows of a run's outcome."""

from __future__ import annotations

import itertools
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from scenarios.names import scenario_names
from sim.tracking import warning
from sim.vehicles import VEHICLES
from validation.scoring.definitions import SCORE_DEFINITIONS, ScoreDefinition
from validation.scoring.outcome import Outcome
from validation.scoring.recommendation import Recommendation
from validation.scoring.scores import Score
from validation.text import digits, duration, plainly, sentence, symbol, words

CALIBRATORS_A_TABLE = 4
ALIGNED = "† after removal of the rotation, which the field strength cannot determine."
STATUS_WORDS = {
    "ok": "ok", "not_converged": "not converged", "unobservable": "unobservable", "not_applicable": "not applicable",
}  # fmt: skip


def rms_length(values: Array) -> float:
    """Return the root mean square of the finite values (n,); of vectors (n, 3), of their lengths."""
    square = values**2 if values.ndim == 1 else np.sum(values**2, axis=1)
    finite = square[np.isfinite(square)]
    return float(np.sqrt(np.mean(finite))) if finite.size else float("nan")


def duration_s(outcome: Outcome) -> float:
    """Return the length of the recording."""
    return float(outcome.recording.time_s[-1] - outcome.recording.time_s[0])


def scenario_description(outcome: Outcome) -> str:
    """Return a description of the scenario in a few sentences."""
    scenario, field = outcome.scenario, outcome.scenario.field
    phases = ", ".join(dict.fromkeys(words(label) for label, _, _ in outcome.phases()))
    place = (
        f"a given field of {', '.join(plainly(v) for v in field.enu_nT)} nT (east, north, up)"
        if field.enu_nT is not None
        else f"the IGRF-14 field at {field.latitude_deg:g}° latitude, {field.longitude_deg:g}° longitude, {field.date},"
    )
    sensors = "one three-axis magnetometer" if outcome.sensors == 1 else f"{outcome.sensors} three-axis magnetometers"
    acting = acting_effects(outcome)
    names, idle = [words(name) for name in acting], [words(name) for name in outcome.effects if name not in acting]
    injected = f"Effects injected ({len(names)}): {', '.join(names)}." if names else "No effect was injected."
    injected += f" Without a contribution to the field: {', '.join(idle)}." if idle else ""
    moved, length = VEHICLES[scenario.vehicle.kind].noun, duration(duration_s(outcome))
    return (
        f"{moved[0].upper()}{moved[1:]} moved through {phases} in {place} for {length}, "
        f"carrying {sensors} sampled at {scenario.sampling.rate_hz:g} Hz. {injected}"
    )


def acting_effects(outcome: Outcome) -> dict[str, Array]:
    """Return the contributions (n, 3) of the effects that change the measured field, in the order of the chain."""
    return {name: value for name, value in outcome.effects.items() if value.any()}


FAILED_LAST = "Failed and ranked last:"
"""Text before the failures."""
ONE_RUN = "This is a single run. For confidence intervals over many runs:"
"""Text before the command that compares."""


def headline(outcome: Outcome) -> str:
    """Return answer, failures and caveats as Markdown, readable on a terminal too."""
    found = outcome.answer()
    paragraphs = [sentence(found.sentence)]
    if found.failed:
        paragraphs.append("\n".join([FAILED_LAST, "", *(f"- {who}: {why}" for who, why in failed_calibrators(found))]))
    paragraphs += [f"{text}." for text in found.closer]
    return "\n\n".join([*paragraphs, f"{ONE_RUN} `{compare_command(outcome)}`"])


def failed_calibrators(recommendation: Recommendation) -> list[tuple[str, str]]:
    """Return name with status, and reason, of each failed calibrator, best first."""
    return [
        (f"{name} ({STATUS_WORDS[status.kind]})", _one_line(status.reason))
        for name, status in recommendation.failed.items()
    ]


def compare_command(outcome: Outcome) -> str:
    """Return the command that runs the scenario, as asked for, many times; SCENARIO.toml for one made in Python."""
    name, *changes = outcome.asked
    named = name or (outcome.scenario.name if outcome.scenario.name in scenario_names() else "SCENARIO.toml")
    options = "".join(f" --set {shlex.quote(change)}" for change in changes)
    return f"magbench compare {shlex.quote(named)} --trials 100{options}"


def score_table(outcome: Outcome) -> dict[str, Any]:
    """Return the table of calibrators and scores, best first; the ranking score stands first.

    heads: name, unit, in_sample, ranks (orders the rows), meaning; rows: name, kind, status, time, cells; by: the
    ranking score in words; aligned: whether a cell has the mark of a removed rotation; meanings: of every score in
    the table. In-sample scores stand last and rank nothing.
    """
    by = outcome.ranking()[1]
    given = {s.name for s in _every_score(outcome)}
    meanings = sorted((one for one in SCORE_DEFINITIONS.values() if one.name in given), key=lambda one: one.name != by)
    shown = [one for one in meanings if one.name not in SHOWN_ELSEWHERE]
    return {
        "heads": [_head(one, by) for one in shown],
        "rows": [_table_row(outcome, name, shown) for name in outcome.rows()],
        "by": SCORE_DEFINITIONS[by].short if by else "",
        "aligned": any(s.rotation_removed for s in _every_score(outcome)),
        "time": SCORE_DEFINITIONS["wall_time"],
        "meanings": [one for one in meanings if one.name != "failure"],
    }


SHOWN_ELSEWHERE = ("failure", "wall_time")
"""Scores that the table's own columns already say."""


def _every_score(outcome: Outcome) -> Iterator[Score]:
    return itertools.chain.from_iterable(outcome.scores.values())


def _head(one: ScoreDefinition, by: str) -> dict[str, Any]:
    """Return the head of a score's column."""
    return {
        "name": one.short,
        "unit": symbol(one.unit),
        "in_sample": one.in_sample,
        "ranks": one.name == by,
        "meaning": one.explained,
    }


def _table_row(outcome: Outcome, name: str, shown: Sequence[ScoreDefinition]) -> dict[str, Any]:
    """Return the row of a calibrator, or of the raw measurement."""
    scores = {s.name: s for s in outcome.scores.get(name, [])}
    cells = [_cell(scores.get(one.name)) for one in shown]
    return {"name": name, **_fit_in_words(outcome.calibrations.get(name)), "cells": cells}


def _fit_in_words(calibration: Calibration | None) -> dict[str, Any]:
    """Return status and time of a fit; dashes for the raw measurement."""
    if calibration is None:
        return {"kind": "", "status": "–", "time": NO_CELL}
    status, wall_s = calibration.status, calibration.wall_s
    return {"kind": status.kind, "status": STATUS_WORDS[status.kind], "time": ScoreCell(digits(wall_s, 2), wall_s)}


@dataclass(frozen=True)
class ScoreCell:
    """Text of a table cell and the number that sorts the column; None without a number."""

    text: str
    value: float | None


NO_CELL = ScoreCell("–", None)


def _cell(score: Score | None) -> ScoreCell:
    if score is None:
        return NO_CELL
    counted = not score.unit and float(score.value).is_integer()
    text = plainly(score.value) if counted else digits(score.value)
    return ScoreCell(text + ("†" if score.rotation_removed else ""), score.value if np.isfinite(score.value) else None)


def notes_markdown(outcome: Outcome) -> str:
    """Return scenario and scores as Markdown, a column per calibrator, at most CALIBRATORS_A_TABLE to a table."""
    table = score_table(outcome)
    lines = [f"# {outcome.scenario.name}", "", headline(outcome), ""]
    lines += [outcome.scenario.summary, "", scenario_description(outcome)]
    if astray := warning([outcome.tracking]):
        lines += ["", f"**Warning: {astray}.**"]
    if outcome.sensors > 1:
        lines += ["", f"Of the {outcome.sensors} magnetometers the recording shows sensor 1."]
    for first in range(0, len(table["rows"]), CALIBRATORS_A_TABLE):
        lines += ["", *_columns(table["heads"], table["rows"][first : first + CALIBRATORS_A_TABLE])]
    lines += ["", *(f"- {one.short}: {one.explained}" for one in table["meanings"])]
    lines += ["", "In-sample scores rank nothing." + (" " + ALIGNED if table["aligned"] else "")]
    return "\n".join([*lines, "", f"Seed {outcome.scenario.seed}."]) + "\n"


def _columns(heads: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[str]:
    """Return the lines of a table with a column for each calibrator."""
    names = [f"{h['name']} ({h['unit'] or '–'})" for h in heads]
    cells = [_row([name, *(row["cells"][k].text for row in rows)]) for k, name in enumerate(names)]
    top = [_row(["", *(row["name"] for row in rows)]), _row(["---"] * (1 + len(rows)))]
    return [*top, _row(["status", *(row["status"] for row in rows)]), *cells]


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(_one_line(cell).replace("|", "\\|") for cell in cells) + " |"


def _one_line(text: str) -> str:
    return " ".join(text.split())
