"""Reproductions of five papers: printed figures and claims against the bench's own, a folder per paper.

Each folder has `trials` (a pure function of a seed or task), `rows` (verdict per printed figure), `figures` and
`paper` (the `Reproduction`); further ``..._trials`` and ``..._rows`` hold a second experiment. A new paper: a folder
and a line in ``PAPERS``.
"""

from __future__ import annotations

from papers.base import Findings, PaperRow, Reproduction
from scenarios.errors import InputError

PAPERS: dict[str, tuple[str, str]] = {
    "zhang2018": ("zhang2018", "Zhang2018"),
    "li2017": ("li2017", "Li2017"),
    "long2013": ("long2013", "Long2013"),
    "zhou2012": ("zhou2012", "Zhou2012"),
    "ding2021": ("ding2021", "Ding2021"),
}
"""Folder and class of each paper's reproduction; imported on demand."""


def chosen(key: str, seeds: int) -> list[Reproduction]:
    """Return the reproduction of a key in any case, or of all papers; raises InputError with the list of keys."""
    from importlib import import_module

    keys = list(PAPERS) if key.lower() == "all" else [key.lower()]
    if keys[0] not in PAPERS:
        raise InputError(f"no paper {key!r}", where="KEY", do=f"choose among {', '.join(PAPERS)}, all")
    classes = [getattr(import_module(f"{__name__}.{folder}.paper"), name) for folder, name in (PAPERS[k] for k in keys)]
    return [cls(seeds=seeds) for cls in classes]


__all__ = ["PAPERS", "Findings", "PaperRow", "Reproduction", "chosen"]
