"""The description of a split dataset for people and programs: table of runs, dataset card, Croissant."""

from __future__ import annotations

from pathlib import Path

from recordings.description.card import write_card
from recordings.description.croissant import write_croissant
from recordings.description.runs import write_runs_table
from recordings.manifest import Manifest
from recordings.split import Split

__all__ = ["describe"]


def describe(out: Path, dataset: Manifest, split: Split) -> None:
    """Write OUT/runs.parquet, OUT/README.md and OUT/croissant.json; equal datasets give equal bytes."""
    write_runs_table(out, dataset, split)
    write_card(out, dataset, split)
    write_croissant(out, dataset, split)
