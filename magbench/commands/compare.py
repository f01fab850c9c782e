"""`magbench compare`: which calibrator, over many trials."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.options import CORES, Exec, Jobs, Json, Out, Overrides, ScenarioName, Scheduler, Seed, TimeLimit, With
from validation.calibrating.processes import TIME_LIMIT_S

if TYPE_CHECKING:
    from scenarios.sweep import Sweep
    from sim.scenario import Scenario

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
    str | None, typer.Option("--reference", metavar="NAME", help="Who ratios are to.  [default: the best]")
]


def compare(
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
    """Compare calibrators over many trials of a scenario; repeat the command to resume or to add trials.

    Who calibrates is given by --with and --exec, else by the scenario.

    Example: magbench compare quad-calibration --trials 100 --with ellipsoid,sphere --sweep noise_std_nT=5,50 -o out/c
    """
    from magbench.arguments import chosen, engine
    from magbench.console import emit, progress, say
    from magbench.tables import show_comparison
    from reports.outputs.comparison import compare as run
    from reports.outputs.comparison import comparison_question, summary
    from sim.scenario import load
    from validation.comparison.design import Design

    asked = comparison_question(rank_by, reference, until)
    spec = load(scenario, set_ or ())
    place = out or Path("out") / f"{spec.name}-comparison"
    design = Design.of(spec, chosen(with_, exec_, time_limit_s, spec.calibrators), _sweeps(sweep, spec), seed)
    with progress(f"comparing on {spec.name}") as report:
        found = run(design, trials, place, engine(scheduler, jobs), report, asked)
    if json:
        emit(summary(found, design.seed) | {"out": str(place)})
    else:
        show_comparison(found)
    say(f"{place}: report.html, trials.parquet, timings.parquet, comparison.json, recordings")


def _sweeps(texts: list[str] | None, scenario: Scenario) -> list[Sweep]:
    from scenarios.sweep import parse_sweep

    return [parse_sweep(text, scenario) for text in texts or ()]
