"""The page of a calibration's output directory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from calib import Calibration, Reference
from recordings import Recording
from recordings.files import system_errors_about, write_text
from reports.pages.calibration import calibration_page
from reports.presentation.calibration import PresentedCalibrations

PAGE = "report.html"


def write_calibration_page(
    found: PresentedCalibrations,
    results: Mapping[str, Calibration],
    recording: Recording,
    reference: Reference,
    out: Path,
    written: Sequence[str],
) -> None:
    """Write OUT/report.html; written : the other files, a line each. InputError where the system refuses."""
    with system_errors_about(out, "choose another directory"):
        out.mkdir(parents=True, exist_ok=True)
    write_text(out / PAGE, calibration_page(found, results, recording, reference, written))
