"""The page of a corrected recording, beside it."""

from __future__ import annotations

from pathlib import Path

from recordings.files import write_text
from reports.pages.correction import correction_page
from reports.presentation.correction import PresentedCorrection
from validation.calibrating.calibration_file import AppliedFile


def write_correction_page(found: PresentedCorrection, applied: AppliedFile) -> Path:
    """Write the page beside the corrected recording, with the ending .html; InputError where the system refuses."""
    page = found.out.with_suffix(".html")
    write_text(page, correction_page(found, applied))
    return page
