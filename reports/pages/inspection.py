"""Page of an inspection: findings by section, then plots of each magnetometer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from reports.pages.section import DrawnSection, Section, drawn_sections
from reports.pages.template import render_page
from reports.plots.inspection import (
    draw_allan,
    draw_coverage,
    draw_low_digits,
    draw_residual,
    draw_spectrum,
    draw_strength,
)
from reports.text.inspection import ENOUGH, MARKS, answer_texts, attention_points, finding_name, value_and_unit
from validation.inspection.inspection import Inspection
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.text import duration, figure


def _moves(data: SensorData) -> bool:
    return len(data.series) > 0 and bool(data.series.mag_nT.any())


def _has_residual(data: SensorData) -> bool:
    return data.residual is not None and bool(data.residual.values.any())


def _has_even_residual(data: SensorData) -> bool:
    return _has_residual(data) and data.even and len(data.fresh) > 2 * POLICY.least_rows


SECTIONS = (
    Section("Coverage of the sphere",
            "Directions of the field in the body frame; each half of the sphere is a disc of equal area. Blue: cells "
            "with samples. A calibration is uncertain along directions in large white areas.", draw_coverage, _moves),
    Section("Field and strength",
            "Calibration removes a variation of the strength that follows the motion, but not a variation that "
            "remains after the ellipsoid fit.", draw_strength, lambda data: len(data.series) > 1),
    Section("Residual",
            "Field minus a base model: the known attitude, else a constant strength, else the mean.", draw_residual,
            _has_residual),
    Section("Spectrum of the residual",
            "Thick: local background. Dashed: tones. Orange marks: alias of the mains frequency at the sample rate.",
            draw_spectrum, _has_even_residual),
    Section("Allan deviation of the residual", "Dashed: white noise alone. Values above the line are slow changes.",
            draw_allan, _has_even_residual),
    Section("Low digits",
            "A sound converter in motion gives bars of equal height. Missing or preferred codes indicate a defect of "
            "the converter or of the log.", draw_low_digits, lambda data: len(data.series) > POLICY.least_rows),
)  # fmt: skip


def inspection_page(inspection: Inspection) -> str:
    """Return the page of an inspection as self-contained HTML."""
    return render_page("inspection.html", _page(inspection))


def _page(inspection: Inspection) -> dict[str, Any]:
    sections = groupby(inspection.findings, key=lambda finding: finding.section)
    answer, warnings = answer_texts(inspection), {one.text for one in inspection.warnings}
    return {
        "file": inspection.log.path.name,
        "answer": answer,
        "suffices": not warnings & {*answer},
        "date": inspection.log.origin.date or "",
        "figures": list(_tiles(inspection)),
        **_attention(inspection, answer),
        "findings": [
            (title, [(finding_name(f), MARKS[f.level], *value_and_unit(f), f.text) for f in findings])
            for title, findings in sections
        ],
        "sections": [section for data in inspection.sensors for section in _sections(data)],
    }


def _attention(inspection: Inspection, answer: Sequence[str]) -> dict[str, list[str]]:
    """Return the warnings that the answer does not tell, and the notes."""
    points, told = attention_points(inspection), {f"{ENOUGH[0]}: {text}" for text in answer}
    return {
        "warnings": [text for mark, text in points if mark == MARKS["warning"] and text not in told],
        "notes": [text for mark, text in points if mark != MARKS["warning"]],
    }


def _tiles(inspection: Inspection) -> Iterator[tuple[str, str, str]]:
    """Yield the headline figures of the first magnetometer (value, unit, label)."""
    known = {(one.section, one.name): one.value for one in reversed(inspection.findings)}
    count = len(inspection.warnings)
    yield str(count), "", "warning" if count == 1 else "warnings"
    time_s = inspection.sensors[0].series.time_s if inspection.sensors else np.empty(0)
    if len(time_s) > 1:
        length, unit = duration(float(np.ptp(time_s))).split()
        yield length, unit, f"{len(time_s)} samples"
    if coverage := known.get(("motion", "coverage")):
        yield figure(100 * coverage["share"], 2), "%", "of the sphere's directions"
    if white := known.get(("noise", "white")):
        yield figure(float(np.sqrt(np.mean(np.square(white))))), "nT", "white noise a sample, rms of the axes"


def _sections(data: SensorData) -> list[DrawnSection]:
    """Draw the sections of one magnetometer; of an array, each title ends with the sensor's number."""
    return drawn_sections(SECTIONS, data, "" if data.sensor is None else f", sensor {data.sensor}")
