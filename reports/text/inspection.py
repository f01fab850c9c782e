"""An inspection on a terminal: the answer, what needs attention, and table rows of every finding."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.inspection.finding import Finding
from validation.inspection.inspection import Inspection, headline
from validation.text import figure, figures

MARKS = {"ok": "", "note": "·", "warning": "!"}
MOST_NUMBERS = 3


ENOUGH = ("calibration", "enough_for")
"""The finding that answers first, also where the answer is no."""
ANSWERS = (ENOUGH, ("time", "samples"), ("motion", "coverage"), ("noise", "white"))
"""Findings that say what the recording is good for, in the order of reading."""


def answer_texts(inspection: Inspection) -> list[str]:
    """Return the sentences of an inspection's first screen: the number of warnings, then what it is good for."""
    found = inspection.findings
    shown = {key: [one for one in found if (one.section, one.name) == key] for key in ANSWERS}
    told = [one.text for key, each in shown.items() for one in each if key == ENOUGH or one.level != "warning"]
    return [headline(inspection), *told]


def attention_points(inspection: Inspection) -> list[tuple[str, str]]:
    """Return mark and sentence of each warning, then of each note that the answer does not hold."""
    marked = sorted((one for one in inspection.findings if one.level != "ok"), key=lambda one: one.level != "warning")
    held = answer_texts(inspection)
    return [
        (MARKS[one.level], f"{one.section}: {one.text}")
        for one in marked
        if one.text not in held or one.level == "warning"
    ]


def finding_rows(inspection: Inspection) -> list[list[str]]:
    """Return rows (name, mark, value, unit, sentence); mark "!": warning, "·": note."""
    return [
        [f"{finding.section}: {finding_name(finding)}", MARKS[finding.level], *value_and_unit(finding), finding.text]
        for finding in inspection.findings
    ]


def finding_name(finding: Finding) -> str:
    """Return a finding's name for readers, with the sensor of an array."""
    return finding.name.replace("_", " ") + ("" if finding.sensor is None else f", sensor {finding.sensor}")


def value_and_unit(finding: Finding) -> tuple[str, str]:
    """Return a finding's value, if at most a few numbers, and the unit."""
    text = _text(finding.value)
    return text, finding.unit if text else ""


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value}"
    if isinstance(value, float | np.floating):
        return figure(float(value))
    if isinstance(value, list) and 0 < len(value) <= MOST_NUMBERS and all(isinstance(v, float | int) for v in value):
        return figures(value).replace(" and ", ", ")
    return ""
