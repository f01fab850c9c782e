"""`magbench run`: the main job, from scenario to report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from magbench.options import Exec, Json, Out, Overrides, ScenarioName, Seed, TimeLimit, With
from validation.calibrating.processes import TIME_LIMIT_S

if TYPE_CHECKING:
    from magbench.api.run_result import RunResult
    from sim.scenario import Scenario
    from validation.scoring.conditions import Condition

FAIL_IF = "--fail-if"
FailIf = Annotated[
    list[str] | None,
    typer.Option(
        FAIL_IF,
        metavar="CONDITION",
        help="End with status 1 where a score is so, e.g. --fail-if 'ellipsoid.heading_rms > 0.1'; repeatable.",
    ),
]


def command(
    scenario: ScenarioName,
    with_: With = None,
    exec_: Exec = None,
    time_limit_s: TimeLimit = TIME_LIMIT_S,
    out: Out = None,
    seed: Seed = None,
    set_: Overrides = None,
    fail_if: FailIf = None,
    full: Annotated[bool, typer.Option("--full", help="Keep every sample in recording.rrd.")] = False,
    json: Json = False,
) -> None:
    """Simulate a scenario, calibrate, and score against the truth. Page and recording are written.

    The calibrators are those of --with and --exec, else the scenario's. Status 1 where a condition of --fail-if
    holds, and where a calibrator of --with or --exec was not applicable.

    Example: magbench run auv-dive -o out/dive --fail-if 'ellipsoid.heading_rms >= 0.1'
    """
    from magbench.api.run import run
    from magbench.arguments import drawn_anew, split
    from magbench.console import end_with, progress, warn
    from sim.scenario import load
    from validation.calibrating.fitting import not_applicable

    changes = set_ or ()
    spec = load(scenario, changes)
    warn(drawn_anew(changes, spec.vary))
    chosen: dict[str, Any] = {"with_": split(with_ or ""), "exec_": exec_ or (), "time_limit_s": time_limit_s}
    conditions = _conditions(fail_if or (), spec, **chosen)
    place = out or Path("out") / spec.name
    with progress(f"running {spec.name}") as report:
        outcome = run(scenario, place, **chosen, overrides=changes, seed=seed, full=full, progress=report, warn=warn)
    failures = [failure for one in conditions if (failure := one.failure(outcome.scores))]
    failures += not_applicable(outcome.calibrations) if with_ or exec_ else []
    _show(outcome, place, failures, json)
    end_with(failures)


def _show(outcome: RunResult, place: Path, failures: Sequence[str], json: bool) -> None:
    from magbench.console import emit, say, warn
    from magbench.score_table import show_scores
    from reports.outputs.run import summary
    from sim.tracking import warning

    if json:
        emit(summary(outcome) | {"out": str(place), "failures": failures})
    else:
        show_scores(outcome)
    warn(warning([outcome.tracking]))
    say(f"{place}: report.html, recording.rrd, scores.json, dataset.json")


def _conditions(texts: Sequence[str], spec: Scenario, **chosen: Any) -> list[Condition]:
    """The conditions of --fail-if on calibrators that take part; InputError otherwise."""
    from magbench.api.inputs import calibrators_from
    from validation.scoring.conditions import Condition, row_names

    conditions = [Condition.parsed(text, FAIL_IF) for text in texts]
    names = [entry.name for entry in calibrators_from(**chosen, otherwise=spec.calibrators)]
    for condition in conditions:
        condition.check(row_names(names, len(spec.sensors)))
    return conditions
