"""`magbench bound`: the accuracy that any method can reach, and what the motion cannot tell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from magbench.arguments import field_vector, none_of
from magbench.options import FieldStrength, FieldVector, Json, Maps, Overrides
from scenarios.names import find

if TYPE_CHECKING:
    from sim.scenario import Scenario
    from validation.bound.experiment import Experiment
    from validation.bound.query import BoundAnswer, BoundQuery

WHAT_IF = "--what-if"
Source = Annotated[
    str, typer.Argument(metavar="SCENARIO|DATA", help="A scenario's name or TOML file, a dataset or a log.")
]
Knowledge = Annotated[
    Literal["norm", "norm+gyro", "norm+gyro+accel", "vector", "vector+eddy"],
    typer.Option(
        help="What a method is told of the field: strength, with a gyro, or the whole vector; +eddy: 21 parameters."
    ),
]
Noise = Annotated[
    float | None,
    typer.Option("--noise-std-nT", min=1e-9, help="White noise of each axis.  [default: as found in the data]"),
]
GyroNoise = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        help="White noise of the gyro, each axis of a sample.  [default: the scenario's, of a log 0.001]",
    ),
]
GyroScale = Annotated[
    float, typer.Option(min=0.0, max=1.0, help="What the gyro's scale may be off by, each axis, a fraction; 0: exact.")
]
StrengthUnknown = Annotated[
    bool,
    typer.Option("--strength-unknown", help="The strength is not known either: S up to a factor, its trace fixed."),
]
Coloured = Annotated[
    bool, typer.Option("--coloured", help="With the flicker noise and the random walk that the scenario states.")
]
Values = Annotated[
    str | None,
    typer.Option(
        WHAT_IF,
        metavar="KEY=A:B:STEP",
        help="The bound at values of one of the scenario's, as a table and a plot: KEY=0:30:5 or KEY=A,B,C.",
    ),
]
TILTS = "--tilt-limits"
TiltLimits = Annotated[
    str | None,
    typer.Option(
        TILTS, metavar="ROLL,PITCH", help="The best that any motion within these tilts could do, yaw free; degrees."
    ),
]
WhichRun = Annotated[int | None, typer.Option(min=0, help="Which run of a dataset directory.  [default: 0]")]
Report = Annotated[
    Path | None, typer.Option("--out", "-o", help="Directory of the plots.  [default: out/SCENARIO-bound]")
]


def bound(
    source: Source,
    knowledge: Knowledge = "norm",
    noise_std_nT: Noise = None,
    gyro_noise_rad_s: GyroNoise = None,
    gyro_scale_std: GyroScale = 0.0,
    strength_unknown: StrengthUnknown = False,
    coloured: Coloured = False,
    tilt_limits: TiltLimits = None,
    what_if: Values = None,
    set_: Overrides = None,
    run: WhichRun = None,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
    out: Report = None,
    json: Json = False,
) -> None:
    """Tell the Cramer-Rao bound: the least errors of offset, matrix, heading; and what is not observable.

    Example: magbench bound auv-spiral --what-if roll_amplitude_deg=0:30:5
    """
    path = find(source)
    of_log = {"--run": run, "--field-strength-nT": field_strength_nT, "--field-enu-nT": field_enu_nT, "--map": map_}
    of_scenario = {"--set": set_, WHAT_IF: what_if, "--coloured": coloured or None}
    if not what_if:
        none_of({"--out": out}, f"is for {WHAT_IF} alone", "leave it out")
    from validation.bound.limit import Tilts
    from validation.bound.query import BoundQuery

    tilts = Tilts.parsed(tilt_limits, TILTS) if tilt_limits else None
    question = BoundQuery(
        knowledge, not strength_unknown, noise_std_nT, gyro_noise_rad_s, tilts, coloured, gyro_scale_std
    )
    if path.suffix == ".toml":
        none_of(of_log, "speaks of a log, and this is a scenario", "change the scenario with --set KEY=VALUE")
        _of_scenario(question, path, set_, what_if, out, json)
    else:
        none_of(of_scenario, "speaks of a scenario, and this is a log", "leave it out")
        _tell(question.answer(_log(path, noise_std_nT, run, map_, field_strength_nT, field_enu_nT)), json)


def _of_scenario(
    question: BoundQuery, path: Path, set_: list[str] | None, what_if: str | None, out: Path | None, json: bool
) -> None:
    from sim.scenario import load

    scenario = load(path, set_ or ())
    if what_if:
        _sweep(question, scenario, what_if, out or Path("out") / f"{scenario.name}-bound", json)
    else:
        _tell(question.of_scenario(scenario), json)


def _log(
    path: Path,
    noise_std_nT: float | None,
    run: int | None,
    maps: list[str] | None,
    strength_nT: float | None,
    enu: str | None,
) -> Experiment:
    vector = field_vector(enu)
    from validation.bound.files import recording_experiment

    return recording_experiment(
        path, noise_std_nT=noise_std_nT, run=run or 0, maps=maps or (), strength_nT=strength_nT, enu=vector
    )


def _sweep(question: BoundQuery, scenario: Scenario, text: str, out: Path, json: bool) -> None:
    from magbench.console import emit, say, show_table
    from reports.outputs.bound import write_what_if
    from scenarios.sweep import parse_sweep
    from validation.bound.query import WhatIf
    from validation.bound.summary import what_if_headline, what_if_heads, what_if_rows, what_if_summary

    found = WhatIf.of(question, scenario, parse_sweep(text, scenario, WHAT_IF))
    write_what_if(found, scenario.name, out)
    if json:
        emit({"what_if": what_if_summary(found), "out": str(out)})
    else:
        show_table("", what_if_heads(found), what_if_rows(found))
    say(what_if_headline(found))
    say(f"{out}: report.html, bound.json")


def _tell(found: BoundAnswer, json: bool) -> None:
    from magbench.console import emit, say, show_table
    from validation.bound.summary import headline, rows, summary, use_rows

    if json:
        emit(summary(found))
    else:
        show_table("", ["axis", "offset, nT", "S x", "S y", "S z"], rows(found))
        show_table("", ["at least", "error", "of what"], use_rows(found.used), numbers=False)
    say(headline(found))
