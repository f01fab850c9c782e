"""Reproductions: each paper's figures beside ours, one file a paper; a new one is a line in PAPERS."""

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
"""Folder and class of each paper's reproduction; its `paper` is imported when it is asked for."""


def chosen(key: str, seeds: int) -> list[Reproduction]:
    """The reproduction of that key, or `all`, whatever its case; raises InputError listing the keys."""
    from importlib import import_module

    keys = list(PAPERS) if key.lower() == "all" else [key.lower()]
    if keys[0] not in PAPERS:
        raise InputError(f"no paper {key!r}", where="KEY", do=f"choose among {', '.join(PAPERS)}, all")
    classes = [getattr(import_module(f"{__name__}.{folder}.paper"), name) for folder, name in (PAPERS[k] for k in keys)]
    return [cls(seeds=seeds) for cls in classes]


__all__ = ["PAPERS", "Findings", "PaperRow", "Reproduction", "chosen"]
