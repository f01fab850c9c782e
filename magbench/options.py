"""Shared options and arguments of the commands, each with help text, check and completion."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from magbench.arguments import complete_calibrators, complete_scenario, known_calibrators, known_scenario, present
from validation.calibrating.processes import LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S

ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A name of `magbench list scenarios`, or a TOML file.",
        callback=known_scenario,
        autocompletion=complete_scenario,
    ),
]
Data = Annotated[
    Path,
    typer.Argument(metavar="DATA", help="A dataset directory, a run, or a Parquet or CSV log.", callback=present),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a value, e.g. --set effects.white_noise.std_nT=[5,5,5]"),
]
Run = Annotated[int, typer.Option(min=0, help="Which run of a dataset directory.")]
FieldStrength = Annotated[
    float | None,
    typer.Option("--field-strength-nT", help="Field strength; a simulated run knows its own."),
]
FieldVector = Annotated[
    str | None, typer.Option("--field-enu-nT", metavar="E,N,U", help="Field vector, east, north, up.")
]
With = Annotated[
    str | None,
    typer.Option(
        "--with",
        metavar="NAME,...",
        help="Calibrators, comma-separated: names of `magbench list calibrators`, also with options "
        "(ml_geometric:huber, twostep:rounds=9), or module:object.",
        callback=known_calibrators,
        autocompletion=complete_calibrators,
    ),
]
Exec = Annotated[
    list[str] | None,
    typer.Option(
        "--exec",
        metavar="COMMAND",
        help="A program that calibrates, e.g. 'mine=./mycal {recording.csv} {result}'.",
    ),
]
TimeLimit = Annotated[
    float,
    typer.Option(
        "--time-limit-s",
        min=LEAST_TIME_LIMIT_S,
        max=MOST_TIME_LIMIT_S,
        help="For one fit of a calibrator that is not magbench's.",
    ),
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/SCENARIO]")]
Seed = Annotated[
    int | None, typer.Option(min=0, max=2**63 - 1, help="Seed of all randomness.  [default: the scenario's]")
]
Jobs = Annotated[int, typer.Option(min=1, help="Processes; they never change a figure.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Compute on a Dask cluster, e.g. tcp://host:8786.")
]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output, all else on standard error.")]

CORES = os.cpu_count() or 1
