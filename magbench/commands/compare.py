"""`magbench compare`: which calibrator, over many trials."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import CORES, Exec, Jobs, Json, Out, Overrides, ScenarioName, Scheduler, Seed, TimeLimit, With
from validation.calibrating.children import TIME_LIMIT_S

Trials = Annotated[int, typer.Option(min=1, max=10_000_000, help="Number of trials at every point of the sweep.")]
Sweeps = Annotated[
    list[str] | None,
    typer.Option("--sweep", metavar="KEY=A,B,C", help="Values that one of the scenario's takes; repeatable."),
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
    set_: Overrides = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Compare calibrators over many trials of a scenario; repeat the command to resume or to add trials.

    Who calibrates is given by --with and --exec, else by the scenario.

    Example: magbench compare quad-calibration --trials 100 --with ellipsoid,sphere --sweep noise_std_nT=5,50 -o out/c
    """
    from magbench.arguments import chosen
    from magbench.console import emit, progress, say
    from scenarios.sweep import parse_sweep
    from sim.scenario import load
    from validation.comparison.cluster import Cluster
    from validation.comparison.design import Design
    from validation.comparison.engine import Processes
    from validation.outputs.comparison import compare as run
    from validation.outputs.comparison import summary

    spec = load(scenario, set_ or ())
    place = out or Path("out") / f"{spec.name}-comparison"
    calibrators = chosen(with_, exec_, time_limit_s, spec.calibrators)
    design = Design.of(spec, calibrators, [parse_sweep(text, spec) for text in sweep or ()], seed)
    engine = Cluster(scheduler) if scheduler else Processes(jobs)
    with progress(f"comparing on {spec.name}") as report:
        table = run(design, trials, place, engine, report)
    if json:
        emit(summary(design, table) | {"out": str(place)})
    say(f"{place}: trials.parquet, timings.parquet, comparison.json")
