"""Options and arguments that several commands share, each with its help text."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

ScenarioName = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="A name of `magbench list scenarios`, or a TOML file.")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a value, e.g. --set effects.white_noise.std_nT=[5,5,5]"),
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/SCENARIO]")]
Seed = Annotated[
    int | None, typer.Option(min=0, max=2**63 - 1, help="Seed of all randomness.  [default: the scenario's]")
]
Jobs = Annotated[int, typer.Option(min=1, help="Processes; they never change a figure.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output, all else on standard error.")]

CORES = os.cpu_count() or 1
