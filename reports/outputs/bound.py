"""Files of a bound, and of a bound over the values of a key: page and numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.pages.bound import bound_page, what_if_page
from validation.bound.query import BoundAnswer, WhatIf
from validation.bound.summary import summary, what_if_summary


def write_bound(found: BoundAnswer, title: str, out: Path) -> None:
    """Write OUT/report.html and OUT/bound.json; raises InputError where the system refuses to write."""
    _write(summary(found), bound_page(found, title), out)


def write_what_if(what_if: WhatIf, title: str, out: Path) -> None:
    """Write OUT/report.html and OUT/bound.json; raises InputError where the system refuses to write."""
    _write(what_if_summary(what_if), what_if_page(what_if, title), out)


def _write(numbers: Mapping[str, Any], page: str, out: Path) -> None:
    with locked_directory(out):
        remove_leftovers(out)
        write_text(out / "bound.json", json.dumps(numbers, indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", page)
