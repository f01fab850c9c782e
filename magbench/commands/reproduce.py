"""`magbench reproduce`: a paper's figures beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import ALL_PAPERS, complete_paper, known_paper
from magbench.options import CORES, Jobs, Json, Scheduler

if TYPE_CHECKING:
    from papers.base import PaperRow


def command(
    key: Annotated[
        str,
        typer.Argument(
            metavar="KEY",
            help="A paper, such as li2017, or all.",
            callback=known_paper,
            autocompletion=complete_paper,
        ),
    ] = ALL_PAPERS,
    out: Annotated[Path, typer.Option("--out", "-o", help="Output directory.")] = Path("out/reproduce"),
    seeds: Annotated[int, typer.Option(min=2, help="Independent repetitions behind every spread.")] = 50,
    jobs: Jobs = CORES,
    scheduler: Scheduler = None,
    json: Json = False,
) -> None:
    """Repeat a paper's experiments beside its printed figures. Each figure has a verdict.

    Example: magbench reproduce li2017 -o out/li
    """
    from magbench.api.reproduce import reproduce
    from magbench.console import emit, progress, say, show_table, show_text
    from papers.report import as_dict

    results = reproduce(key, out, seeds=seeds, jobs=jobs, scheduler=scheduler, reporting=progress)
    if json:
        emit(as_dict(results))
    else:
        show_text("\n".join(f"{paper.key}: {_summary(findings.rows)}" for paper, findings in results.items()) + "\n")
        for paper, findings in results.items():
            rows = [[row.what, row.paper, row.ours, row.verdict, row.tolerance, row.note] for row in findings.rows]
            heads = ["what", "paper", "ours", "verdict", "tolerance", "note"]
            show_table(paper.title, heads, rows, numbers=False)
    say(f"{out}: report.html, reproduction.json")


def _summary(rows: Sequence[PaperRow]) -> str:
    """How many printed figures and claims are confirmed, and which are not."""
    comparable = [row for row in rows if row.verdict != "not comparable"]
    differ = [row.what for row in comparable if not row.holds]
    told = f"{len(comparable) - len(differ)} of {len(comparable)} printed figures and claims confirmed"
    others = f", {len(rows) - len(comparable)} not comparable" if len(comparable) < len(rows) else ""
    return told + others + (f"; not confirmed: {'; '.join(differ)}" if differ else "")
