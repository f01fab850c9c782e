"""`magbench.compare`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import (
    Progress,
    Warn,
    calibrators_from,
    check_count,
    engine,
    in_keywords,
    place_for,
    quiet,
    scenario_from,
)

if TYPE_CHECKING:
    from magbench.api.comparison_result import ComparisonResult
    from sim.scenario import Scenario


@in_keywords()
def compare(
    scenario: str | Path | Scenario,
    out: str | PathLike[str] | None = None,
    *,
    trials: int = 100,
    with_: str | Sequence[str] = (),
    sweep: Sequence[str] = (),
    overrides: Sequence[str] = (),
    seed: int | None = None,
    until: str | None = None,
    rank_by: str | None = None,
    reference: str | None = None,
    exec_: Sequence[str] = (),
    time_limit_s: float | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress = quiet,
    warn: Warn = quiet,
) -> ComparisonResult:
    """Compare calibrators over many trials of a scenario; the same call with `out` resumes or adds trials.

    trials : at every point of the sweep; with `until` the most. with_, exec_ : the calibrators, as in `calibrate`; by
        default the scenario's. sweep : `noise_std_nT=1,5,10` and the like, values of the scenario to compare at.
    until : `median offset_error_nT +-5%`: stop as soon as every median is known so well.
    rank_by : the score that decides. reference : the calibrator that ratios are to; by default the best.
    jobs : processes; by default this process alone. scheduler : address of a Dask cluster, `tcp://host:8786`. Neither
        changes a figure. A script that gives jobs calls this function below `if __name__ == "__main__":`.
    warn : gets a line about damaged trials of `out`, which are computed again.
    out : directory for report.html, trials.parquet, comparison.json and recordings.

    Raises InputError for a bad scenario, sweep or score, an unknown calibrator, and an `out` of another comparison.

    >>> import magbench
    >>> short = ["phases.0.duration_s=60"]
    >>> found = magbench.compare("tumble", trials=5, with_=["ellipsoid", "sphere"], overrides=short)
    >>> found.to_frame()["calibrator"].unique().tolist()
    ['ellipsoid', 'sphere', 'uncorrected']
    """
    from magbench.api.comparison_result import ComparisonResult
    from reports.outputs.comparison import compare as compared
    from reports.outputs.comparison import comparison_question
    from scenarios.sweep import parse_sweep
    from validation.comparison.design import Design

    check_count("--trials", trials)
    check_count("--jobs", jobs)
    asked, spec = comparison_question(rank_by, reference, until), scenario_from(scenario, overrides)
    chosen = calibrators_from(with_, exec_, time_limit_s, spec.calibrators)
    design = Design.of(spec, chosen, [parse_sweep(text, spec) for text in sweep], seed)
    with place_for(out) as place:
        found = compared(design, trials, place, engine(scheduler, jobs), progress, asked, warn)
    return ComparisonResult.of(found, design.seed)
