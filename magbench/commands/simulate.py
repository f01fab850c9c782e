"""`magbench simulate`: write a labelled dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from magbench.options import CORES, Jobs, Json, Overrides, ScenarioName, Scheduler, Seed

if TYPE_CHECKING:
    from recordings import Manifest

Place = Annotated[
    str | None,
    typer.Option("--out", "-o", help="Directory, or a URL such as s3://bucket/data.  [default: out/SCENARIO]"),
]
RunsPerFile = Annotated[int, typer.Option(min=1, help="Runs that share a file, told apart by the column run.")]
SplitShares = Annotated[
    str | None,
    typer.Option(metavar="TRAIN/VALIDATION/TEST", help="For a learner: per cent of the runs, e.g. 80/10/10."),
]


def command(
    scenario: ScenarioName,
    out: Place = None,
    runs: Annotated[int, typer.Option(min=1, help="Number of runs.")] = 1,
    seed: Seed = None,
    jobs: Jobs = CORES,
    scheduler: Scheduler = None,
    runs_per_file: RunsPerFile = 1,
    split: SplitShares = None,
    set_: Overrides = None,
    json: Json = False,
) -> None:
    """Simulate a scenario and write a labelled dataset. Repeat the command to resume or to add runs.

    With --scheduler the workers of a cluster write to OUT, on a shared disk or a URL. --runs-per-file joins short runs.
    With --split the runs lie in OUT/data/train, validation and test, beside a table of all runs and a dataset card.

    Example: magbench simulate auv-spiral -o data --runs 20 --seed 7
    """
    from magbench.api.simulate import simulate
    from magbench.arguments import drawn_anew
    from magbench.console import emit, progress, say, warn
    from recordings.url_path import place_at
    from sim.scenario import load
    from sim.tracking import warning

    spec = load(scenario, set_ or ())
    warn(drawn_anew(set_ or (), spec.vary))
    place = place_at(out or f"out/{spec.name}")
    with progress(f"simulating {spec.name}" + (f", {runs} runs" if runs > 1 else "")) as report:
        made = simulate(
            spec,
            str(place),
            seed=seed,
            runs=runs,
            runs_per_file=runs_per_file,
            split=split,
            jobs=jobs,
            scheduler=scheduler,
            progress=report,
            warn=warn,
        )
    say(f"{place}: {_in_words(made.manifest)}")
    warn(warning([file.tracking for file in made.manifest.files]))
    if json:
        emit({"out": str(place), **_for_scripts(made.manifest)})


def _in_words(manifest: Manifest) -> str:
    from validation.text import counted

    rows = sum(file.rows for file in manifest.files)
    words = f"{counted(manifest.runs, 'run')}, {rows} samples, {len(manifest.columns)} columns"
    if manifest.split is None:
        return words
    counts = manifest.split.counts(manifest.runs)
    return f"{words}; " + ", ".join(f"{counted(runs, 'run')} for {part}" for part, runs in counts.items())


def _for_scripts(manifest: Manifest) -> dict[str, Any]:
    from dataclasses import asdict

    from sim.tracking import together

    whole = together([file.tracking for file in manifest.files])
    told: dict[str, Any] = {"runs": manifest.runs, "seed": manifest.seed}
    if manifest.split is not None:
        told["split"] = manifest.split.counts(manifest.runs)
    told["samples"] = sum(file.rows for file in manifest.files)
    return told | {"tracking": whole and asdict(whole), "files": [asdict(file) for file in manifest.files]}
