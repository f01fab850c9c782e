"""`magbench reproduce`: a paper's figures beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.arguments import ALL_PAPERS, complete_paper, known_paper
from magbench.options import CORES, Jobs, Json, Scheduler


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
    """Repeat a paper's experiments and set its figures beside ours, each with a verdict.

    Example: magbench reproduce li2017 -o out/li
    """
    from magbench.api.reproduce import reproduce
    from magbench.console import emit, progress, say, show_table
    from papers.report import as_dict

    results = reproduce(key, out, seeds=seeds, jobs=jobs, scheduler=scheduler, reporting=progress)
    if json:
        emit(as_dict(results))
    else:
        for paper, findings in results.items():
            rows = [[row.what, row.paper, row.ours, row.verdict, row.tolerance, row.note] for row in findings.rows]
            heads = ["what", "paper", "ours", "verdict", "tolerance", "note"]
            show_table(paper.title, heads, rows, numbers=False)
    say(f"{out}: report.html, reproduction.json")
