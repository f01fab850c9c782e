"""Table rows of an inspection's findings."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.inspection.finding import Finding
from validation.inspection.inspection import Inspection
from validation.text import figure, figures

MARKS = {"ok": "", "note": "·", "warning": "!"}
MOST_NUMBERS = 3


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
        return f"{value:,}"
    if isinstance(value, float | np.floating):
        return figure(float(value))
    if isinstance(value, list) and 0 < len(value) <= MOST_NUMBERS and all(isinstance(v, float | int) for v in value):
        return figures(value).replace(" and ", ", ")
    return ""
