"""Calibrations as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from calib.models.scalar_terms import NAMES
from calib.result import Calibration
from magbench.console import show_table, show_text
from reports.presentation.calibration import offset_texts
from validation.calibrating.output_unit import OutputUnit
from validation.text import figure


def show_calibrations(calibrations: Mapping[str, Calibration]) -> None:
    """Offset, matrix and status of each calibration, dashes without an estimate; then the reasons."""
    rows = [[name, c.status.kind, *_offset_and_matrix(c)] for name, c in calibrations.items()]
    show_table("calibrations", ["calibrator", "status", "offset, nT (95\u00a0%)", "matrix"], rows)
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
        return "–", "–"
    matrix = "\n".join(" ".join(f"{value:8.5f}" for value in row) for row in fit.matrix)
    return "\n".join(offset_texts(fit)), matrix


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
