"""Page and JSON file of the reproductions."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from papers.base import Findings, PaperRow, Reproduction
from recordings.files import system_errors_about, write_text
from reports.pages import section
from reports.pages.template import render_page

Results = Mapping[Reproduction, Findings]


def as_dict(results: Results) -> dict[str, Any]:
    """Return the JSON: papers [{key, title, seeds, rows [{what, paper, ours, holds, verdict, tolerance, note}]}]."""
    papers = [
        {"key": paper.key, "title": paper.title, "seeds": paper.seeds, "rows": [_row(row) for row in findings.rows]}
        for paper, findings in results.items()
    ]
    return {"papers": papers}


def write(results: Results, out: Path) -> None:
    """Write OUT/report.html and OUT/reproduction.json; raises InputError where the system refuses to write."""
    with system_errors_about(out, "choose another directory"):
        out.mkdir(parents=True, exist_ok=True)
    write_text(out / "reproduction.json", json.dumps(as_dict(results), indent=1, ensure_ascii=False) + "\n")
    papers = [
        {
            "paper": paper,
            "rows": findings.rows,
            "pictures": {k: section.figure_html(draw, k) for k, draw in findings.figures.items()},
        }
        for paper, findings in results.items()
    ]
    write_text(out / "report.html", render_page("reproduction.html", {"papers": papers}))


def _row(row: PaperRow) -> dict[str, Any]:
    return {
        "what": row.what,
        "paper": row.paper,
        "ours": row.ours,
        "holds": row.holds,
        "verdict": row.verdict,
        "tolerance": row.tolerance,
        "note": row.note,
    }
