"""The page of a corrected recording, beside it."""

from __future__ import annotations

from pathlib import Path

from recordings.files import system_errors_about, write_text
from reports.pages.correction import correction_page
from reports.presentation.correction import PresentedCorrection
from scenarios.errors import InputError
from validation.calibrating.calibration_file import AppliedFile

MARK = "· magbench apply</title>"
"""In each page of a correction, and in no other file."""


def check_page(out: Path) -> None:
    """Raise InputError where the page beside `out` would replace a file that is not a page of a correction."""
    page = page_of(out)
    with system_errors_about(page):
        foreign = page.exists() and not (page.is_file() and MARK.encode() in page.read_bytes())
    if foreign:
        do = f"name the recording otherwise than {out.name}, move the file, or leave out the page with --no-page"
        raise InputError("is another command's page or a file of yours", where=str(page), do=do)


def page_of(out: Path) -> Path:
    """The page beside a corrected recording."""
    return out.with_suffix(".html")


def write_correction_page(found: PresentedCorrection, applied: AppliedFile) -> Path:
    """Write the page beside the corrected recording, with the ending .html; InputError where the system refuses."""
    page = page_of(found.out)
    write_text(page, correction_page(found, applied))
    return page
