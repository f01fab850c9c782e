"""`magbench simulate`: write a labelled dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import CORES, Jobs, Json, Out, Overrides, ScenarioName, Seed


def simulate(
    scenario: ScenarioName,
    out: Out = None,
    runs: Annotated[int, typer.Option(min=1, max=99_999, help="Number of runs.")] = 1,
    seed: Seed = None,
    jobs: Jobs = CORES,
    set_: Overrides = None,
    json: Json = False,
) -> None:
    """Simulate a scenario and write a labelled dataset; repeat the command to resume or to add runs.

    Example: magbench simulate auv-spiral -o data --runs 20 --seed 7
    """
    from dataclasses import asdict

    from magbench.console import emit, progress, say, warn
    from sim.generate import generate
    from sim.scenario import load
    from sim.tracking import together, warning
    from validation.text import counted

    spec = load(scenario, set_ or ())
    place = out or Path("out") / spec.name
    what = f"simulating {spec.name}" + (f", {runs} runs" if runs > 1 else "")
    with progress(what) as report:
        manifest = generate(spec, place, runs=runs, seed=seed, jobs=jobs, progress=report, warn=warn)
    rows = sum(file.rows for file in manifest.files)
    say(f"{place}: {counted(runs, 'run')}, {rows} samples, {len(manifest.columns)} columns")
    tracks = [file.tracking for file in manifest.files]
    warn(warning(tracks))
    if json:
        whole = together(tracks)
        told = {"out": str(place), "runs": runs, "seed": manifest.seed, "samples": rows}
        told |= {"tracking": whole and asdict(whole), "files": [asdict(file) for file in manifest.files]}
        emit(told)
