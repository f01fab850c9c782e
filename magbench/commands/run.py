"""`magbench run`: the main job, from scenario to report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import Json, Out, Overrides, ScenarioName, Seed

FAIL_IF = "--fail-if"
FailIf = Annotated[
    list[str] | None,
    typer.Option(
        FAIL_IF,
        metavar="CONDITION",
        help="End with status 1 where a score is so, e.g. --fail-if 'ellipsoid.heading_rms > 0.1'; repeatable.",
    ),
]


def run(
    scenario: ScenarioName,
    out: Out = None,
    seed: Seed = None,
    set_: Overrides = None,
    fail_if: FailIf = None,
    json: Json = False,
) -> None:
    """Simulate a scenario, calibrate, score against the truth, write report and recording.

    Example: magbench run auv-dive -o out/dive --fail-if 'ellipsoid.heading_rms > 0.1'
    """
    from magbench.console import emit, progress, say, warn
    from magbench.tables import show_scores
    from sim.scenario import load
    from sim.tracking import warning
    from validation.outputs.run import run_scenario, summary
    from validation.scoring.conditions import Condition, rows

    conditions = [Condition.parsed(text, FAIL_IF) for text in fail_if or ()]
    spec = load(scenario, set_ or ())
    for condition in conditions:
        condition.check(rows(spec.calibrators, len(spec.sensors)))
    place = out or Path("out") / spec.name
    with progress(f"running {spec.name}") as report:
        outcome = run_scenario(spec, place, seed=seed, progress=report, warn=warn)
    failures = [failure for one in conditions if (failure := one.failure(outcome.scores))]
    if json:
        emit(summary(outcome) | {"out": str(place), "failures": failures})
    else:
        show_scores(outcome)
    warn(warning([outcome.tracking]))
    say(f"{place}: report.html, recording.rrd, scores.json, dataset.json")
    for failure in failures:
        warn(failure)
    if failures:
        raise typer.Exit(1)
