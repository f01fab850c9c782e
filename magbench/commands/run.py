"""`magbench run`: the main job, from scenario to report."""

from __future__ import annotations

from pathlib import Path

from magbench.options import Json, Out, Overrides, ScenarioName, Seed


def run(scenario: ScenarioName, out: Out = None, seed: Seed = None, set_: Overrides = None, json: Json = False) -> None:
    """Simulate a scenario, calibrate, score against the truth, write report and recording.

    Example: magbench run auv-dive -o out/dive
    """
    from magbench.console import emit, progress, say, warn
    from magbench.tables import show_scores
    from sim.scenario import load
    from sim.tracking import warning
    from validation.outputs.run import run_scenario, summary

    spec = load(scenario, set_ or ())
    place = out or Path("out") / spec.name
    with progress(f"running {spec.name}") as report:
        outcome = run_scenario(spec, place, seed=seed, progress=report, warn=warn)
    if json:
        emit(summary(outcome) | {"out": str(place)})
    else:
        show_scores(outcome)
    warn(warning([outcome.tracking]))
    say(f"{place}: report.html, recording.rrd, scores.json, dataset.json")
