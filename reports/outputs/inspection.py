"""Files of an inspection: report.html and inspect.json."""

from __future__ import annotations

import json
from pathlib import Path

from recordings.files import system_errors_about, write_text
from reports.pages.inspection import inspection_page
from validation.inspection.inspection import Inspection, summary


def write_inspection(inspection: Inspection, out: Path) -> None:
    """Write OUT/report.html and OUT/inspect.json; raises InputError where the system refuses to write."""
    with system_errors_about(out, "choose another directory"):
        out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(summary(inspection), indent=1, ensure_ascii=False, allow_nan=False)
    write_text(out / "inspect.json", text + "\n")
    write_text(out / "report.html", inspection_page(inspection))
