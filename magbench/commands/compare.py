"""`magbench compare`: which calibrator, over many trials."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import CORES, Exec, Jobs, Json, Out, Overrides, ScenarioName, Scheduler, Seed, TimeLimit, With
from validation.calibrating.processes import TIME_LIMIT_S

Trials = Annotated[int, typer.Option(min=1, max=10_000_000, help="Number of trials at every point of the sweep.")]
Sweeps = Annotated[
    list[str] | None,
    typer.Option("--sweep", metavar="KEY=A,B,C", help="Values that one of the scenario's takes; repeatable."),
]
UntilRule = Annotated[
    str | None,
    typer.Option(
        "--until",
        metavar="RULE",
        help='Stop as soon as every median is known so well, e.g. "median offset_error_nT +-5%"; --trials is the most.',
    ),
]
RankBy = Annotated[
    str | None, typer.Option(metavar="SCORE", help="The score that decides.  [default: that which `run` ranks by]")
]
ReferenceName = Annotated[
    str | None,
    typer.Option("--reference", metavar="NAME", help="The calibrator that ratios refer to.  [default: the best]"),
]


def command(
    scenario: ScenarioName,
    trials: Trials = 100,
    with_: With = None,
    exec_: Exec = None,
    time_limit_s: TimeLimit = TIME_LIMIT_S,
    sweep: Sweeps = None,
    seed: Seed = None,
    jobs: Jobs = CORES,
    scheduler: Scheduler = None,
    until: UntilRule = None,
    rank_by: RankBy = None,
    reference: ReferenceName = None,
    set_: Overrides = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Compare calibrators over many trials of a scenario. Repeat the command to resume or to add trials.

    The calibrators are those of --with and --exec, else the scenario's.

    Example: magbench compare quad-calibration --trials 100 --with ellipsoid,sphere --sweep noise_std_nT=5,50 -o out/c
    """
    from magbench.api.compare import compare
    from magbench.arguments import drawn_anew, split
    from magbench.comparison_tables import show_comparison
    from magbench.console import emit, progress, say, warn
    from sim.scenario import load

    spec = load(scenario, set_ or ())
    warn(drawn_anew(set_ or (), spec.vary))
    place = out or Path("out") / f"{spec.name}-comparison"
    with progress(f"comparing on {spec.name}") as report:
        found = compare(
            spec,
            place,
            trials=trials,
            with_=split(with_ or ""),
            sweep=sweep or (),
            seed=seed,
            until=until,
            rank_by=rank_by,
            reference=reference,
            exec_=exec_ or (),
            time_limit_s=time_limit_s,
            jobs=jobs,
            scheduler=scheduler,
            progress=report,
            warn=warn,
        )
    if json:
        emit(found.summary() | {"out": str(place)})
    else:
        show_comparison(found)
    say(f"{place}: report.html, trials.parquet, timings.parquet, comparison.json, recordings")
