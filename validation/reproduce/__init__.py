"""Reproductions: each paper's figures beside ours, one file a paper; a new one is a line in PAPERS."""

from __future__ import annotations

from scenarios.errors import InputError
from validation.reproduce.base import Findings, Reproduction, Row

PAPERS: dict[str, tuple[str, str]] = {
    "zhang2018": ("validation.reproduce.zhang2018.paper", "Zhang2018"),
    "li2017": ("validation.reproduce.li2017.paper", "Li2017"),
    "long2013": ("validation.reproduce.long2013.paper", "Long2013"),
    "zhou2012": ("validation.reproduce.zhou2012.paper", "Zhou2012"),
    "ding2021": ("validation.reproduce.ding2021.paper", "Ding2021"),
}
"""Module and class of each paper's reproduction, imported when it is asked for."""


def chosen(key: str, seeds: int) -> list[Reproduction]:
    """The reproduction of that key, or `all`, whatever its case; raises InputError listing the keys."""
    from importlib import import_module

    keys = list(PAPERS) if key.lower() == "all" else [key.lower()]
    if keys[0] not in PAPERS:
        raise InputError(f"no paper {key!r}", where="KEY", do=f"choose among {', '.join(PAPERS)}, all")
    classes = [getattr(import_module(module), name) for module, name in (PAPERS[k] for k in keys)]
    return [cls(seeds=seeds) for cls in classes]


__all__ = ["PAPERS", "Findings", "Reproduction", "Row", "chosen"]
