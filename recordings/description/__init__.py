"""The description of a split dataset for people and programs: table of runs, dataset card, Croissant."""

from __future__ import annotations

from recordings.description.card import write_card
from recordings.description.croissant import write_croissant
from recordings.description.runs import write_runs_table
from recordings.manifest import Manifest
from recordings.url_path import Place

__all__ = ["describe"]


def describe(out: Place, dataset: Manifest) -> None:
    """Write OUT/runs.parquet, for a split dataset OUT/README.md and OUT/croissant.json; nothing for one run a file.

    Equal datasets give equal bytes.
    """
    if dataset.layout.numbered:
        write_runs_table(out, dataset)
    if dataset.split is not None:
        write_card(out, dataset, dataset.split)
        write_croissant(out, dataset, dataset.split)
