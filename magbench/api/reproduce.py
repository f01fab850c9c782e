"""`magbench.reproduce`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from os import PathLike
from typing import TYPE_CHECKING

from magbench.api.inputs import Progress, check_count, in_keywords, locked, tasks_on

if TYPE_CHECKING:
    from papers.base import Findings, Reproduction

Reporting = Callable[[str], AbstractContextManager[Progress]]
"""(what is computed) -> a context whose value takes (pieces done, pieces in all)."""


def _silent(what: str) -> AbstractContextManager[Progress]:
    return nullcontext(lambda done, total: None)


@in_keywords()
def reproduce(
    key: str = "all",
    out: str | PathLike[str] | None = None,
    *,
    seeds: int = 50,
    jobs: int = 1,
    scheduler: str | None = None,
    reporting: Reporting = _silent,
) -> dict[Reproduction, Findings]:
    """Repeat the experiments of a paper, or of all: its figures beside the bench's, each with a verdict.

    key : zhang2018, li2017, long2013, zhou2012, ding2021 or all. seeds : repetitions behind every spread.
    jobs : processes. scheduler : address of a Dask cluster, `tcp://host:8786`. Neither changes a figure.
    out : directory for report.html and reproduction.json. Raises InputError for an unknown key.

    >>> import magbench
    >>> ((paper, findings),) = magbench.reproduce("zhou2012", seeds=2).items()
    >>> paper.key, any(row.verdict == "holds" for row in findings.rows)
    ('Zhou2012', True)
    """
    from papers import chosen
    from papers.base import computed_on
    from papers.report import write

    check_count("--seeds", seeds, 2)
    check_count("--jobs", jobs)
    results = {}
    papers = chosen(key, seeds)
    with locked(out) as place, computed_on(tasks_on(scheduler)):
        for paper in papers:
            with reporting(f"reproducing {paper.key}") as progress:
                results[paper] = paper.run(jobs=jobs, progress=progress)
        if place is not None:
            write(results, place)
    return results
