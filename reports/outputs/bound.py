"""Files of a bound swept over the values of a key: page and numbers."""

from __future__ import annotations

import json
from pathlib import Path

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.pages.bound import bound_page
from validation.bound.query import WhatIf
from validation.bound.summary import what_if_summary


def write_what_if(what_if: WhatIf, title: str, out: Path) -> None:
    """Write OUT/report.html and OUT/bound.json; raises InputError where the system refuses to write."""
    with locked_directory(out):
        remove_leftovers(out)
        write_text(out / "bound.json", json.dumps(what_if_summary(what_if), indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", bound_page(what_if, title))
