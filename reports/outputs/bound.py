"""What a bound says over the values of one key, on disk: a page and the numbers."""

from __future__ import annotations

import json
from pathlib import Path

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.pages.bound import bound_page
from validation.bound.query import WhatIf
from validation.bound.summary import what_if_summary


def write_what_if(found: WhatIf, title: str, out: Path) -> None:
    """Write OUT/report.html and OUT/bound.json; raises InputError when the system refuses."""
    with locked_directory(out):
        remove_leftovers(out)
        write_text(out / "bound.json", json.dumps(what_if_summary(found), indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", bound_page(found, title))
