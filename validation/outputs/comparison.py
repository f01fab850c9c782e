"""A comparison on disk: its trials as they land, then its tables and what was compared."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from scenarios.plain import json_ready
from sim.dataset.files import locked_directory, remove_leftovers, write_text
from validation.comparison.design import Design
from validation.comparison.engine import Engine, run_trials
from validation.comparison.journal import Journal
from validation.comparison.table import Table

Progress = Callable[[float, int], object]
"""Told (trials done, trials in all)."""
ANSWER = "comparison.json"


def compare(
    design: Design,
    trials: int,
    out: Path,
    engine: Engine,
    progress: Progress = lambda done, total: None,
) -> Table:
    """Compute `trials` trials at every point and write OUT/trials.parquet, timings.parquet and comparison.json.

    Trials that OUT holds are kept: a killed comparison goes on where it was, and a larger number extends it. The
    bytes of trials.parquet depend on design and number alone. Raises InputError where OUT holds another comparison or
    another process writes to it, and where a trial cannot be simulated.
    """
    with locked_directory(out):
        remove_leftovers(out)
        journal = Journal.open(out, design.identity())
        total = trials * len(design.points)
        for done, _ in enumerate(run_trials(design, range(trials), engine, journal), start=1):
            progress(done, total)
        table = Table.of(design, (trial for trial in journal if trial.run < trials))
        table.write(out)
        write_text(out / ANSWER, json.dumps(summary(design, table), indent=1, allow_nan=False) + "\n")
    return table


def summary(design: Design, table: Table) -> dict[str, Any]:
    """What was compared, as plain values."""
    found: dict[str, Any] = json_ready(
        {
            "scenario": design.points[0].scenario.name,
            "seed": design.seed,
            "trials": len(table.runs()),
            "calibrators": table.calibrators,
            "scores": table.scores,
            "points": [{"point": point, **values} for point, values in table.points.items()],
        }
    )
    return found
