"""An inspection as one HTML page and one JSON file."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from markupsafe import Markup

from recordings.files import system_errors_about, write_text
from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.inspection import (
    draw_allan,
    draw_coverage,
    draw_low_digits,
    draw_residual,
    draw_spectrum,
    draw_strength,
)
from reports.plots.style import Figure
from reports.text.inspection import MARKS, finding_name, value_and_unit
from validation.inspection.inspection import Inspection, headline, summary
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY


@dataclass(frozen=True)
class Picture:
    """A picture with its heading, what to look for in it, and whether there is enough to draw it."""

    title: str
    caption: str
    draw: Callable[[SensorData], Figure]
    has: Callable[[SensorData], bool]


def _moves(data: SensorData) -> bool:
    return len(data.series) > 0 and bool(data.series.mag_nT.any())


def _left(data: SensorData) -> bool:
    return data.residual is not None and bool(data.residual.values.any())


def _evenly_left(data: SensorData) -> bool:
    return _left(data) and data.even and len(data.fresh) > 2 * POLICY.least_rows


PICTURES = (
    Picture("Coverage of the sphere", "Directions of the field in the body frame, each half of the sphere on a disc of "
            "equal area. Blue cells were entered. Large white stretches leave a calibration unsure along them.",
            draw_coverage, _moves),
    Picture("Field and strength", "A strength that goes with the motion is what calibration removes; one that goes on "
            "varying after the ellipsoid fit is not.", draw_strength, lambda data: len(data.series) > 1),
    Picture("What is left", "The field less what a base model explains: attitude, else a constant strength, else the "
            "mean.", draw_residual, _left),
    Picture("Spectrum of what is left", "Thick: local background. Dashed: tones. Orange marks: where the mains would "
            "appear at this rate.", draw_spectrum, _evenly_left),
    Picture("Allan deviation of what is left", "Dashed: white noise alone. Above it there are slow changes.",
            draw_allan, _evenly_left),
    Picture("Low digits", "Even heights are what a sound converter gives in motion. Missing or preferred codes point "
            "to the converter or to the log.", draw_low_digits, lambda data: len(data.series) > POLICY.least_rows),
)  # fmt: skip


def write_inspection(inspection: Inspection, out: Path) -> None:
    """Write OUT/report.html and OUT/inspect.json; raises InputError when the system refuses."""
    with system_errors_about(out, "choose another directory"):
        out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(summary(inspection), indent=1, ensure_ascii=False, allow_nan=False)
    write_text(out / "inspect.json", text + "\n")
    write_text(out / "report.html", render_page("inspection.html", _page(inspection)))


def _page(inspection: Inspection) -> dict[str, Any]:
    sections = groupby(inspection.findings, key=lambda finding: finding.section)
    return {
        "file": inspection.log.path.name,
        "lead": headline(inspection),
        "warnings": [finding.text for finding in inspection.warnings],
        "sections": [
            (title, [(finding_name(f), MARKS[f.level], *value_and_unit(f), f.text) for f in findings])
            for title, findings in sections
        ],
        "pictures": [picture for data in inspection.sensors for picture in _pictures(data)],
    }


def _pictures(data: SensorData) -> list[tuple[str, str, Markup]]:
    """Title, caption and figure of each picture of one magnetometer."""
    which = "" if data.sensor is None else f", sensor {data.sensor}"
    drawn = (picture for picture in PICTURES if picture.has(data))
    titled = ((picture.title + which, picture) for picture in drawn)
    return [(title, picture.caption, figure_html(partial(picture.draw, data), title)) for title, picture in titled]
