"""`magbench bound`: the accuracy that any method can reach, and what is not observable."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from magbench.arguments import field_vector, none_of
from magbench.options import FieldStrength, FieldVector, Json, Overrides
from magbench.reading_options import reads_logs
from scenarios.names import find

if TYPE_CHECKING:
    from magbench.api.planning_results import BoundResult, WhatIfResult
    from recordings.reading import Reading

WHAT_IF = "--what-if"
Source = Annotated[
    str, typer.Argument(metavar="SCENARIO|DATA", help="A scenario's name or TOML file, a dataset or a log.")
]
Knowledge = Annotated[
    Literal["norm", "norm+gyro", "norm+gyro+accel", "vector", "vector+eddy"],
    typer.Option(
        help="Knowledge of the method: the field strength, with a gyro, or the field vector; +eddy: 21 parameters."
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
PARAMETERS_TITLE = "least standard deviations; S: soft iron"
TiltLimits = Annotated[
    str | None,
    typer.Option(
        TILTS, metavar="ROLL,PITCH", help="The best that any motion within these tilts could do, yaw free; degrees."
    ),
]
WhichRun = Annotated[int | None, typer.Option(min=0, help="Which run of a dataset directory.  [default: 0]")]
Report = Annotated[
    Path | None,
    typer.Option("--out", "-o", help=f"Directory of page and numbers.  [with {WHAT_IF}: out/SCENARIO-bound]"),
]


@reads_logs("source")
def command(
    source: Source,
    reading: Reading,
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
    out: Report = None,
    json: Json = False,
) -> None:
    """Compute the least errors that any method can reach.

    The Cramer-Rao bound of offset, matrix and heading, and what is not observable.

    Example: magbench bound auv-spiral --what-if roll_amplitude_deg=0:30:5
    """
    from magbench.api.bound import bound, is_scenario
    from magbench.console import progress

    of_log = {"--run": run, "--field-strength-nT": field_strength_nT, "--field-enu-nT": field_enu_nT}
    of_scenario = {"--set": set_, WHAT_IF: what_if, "--coloured": coloured or None}
    known: dict[str, Any] = {
        "knowledge": knowledge,
        "noise_std_nT": noise_std_nT,
        "gyro_noise_rad_s": gyro_noise_rad_s,
        "gyro_scale_std": gyro_scale_std,
        "strength_unknown": strength_unknown,
        "tilt_limits": tilt_limits,
    }
    if is_scenario(source):
        none_of(
            {**of_log, **reading.stated},
            "applies to a log, and this is a scenario",
            "change the scenario with --set KEY=VALUE",
        )
        known |= {"coloured": coloured, "overrides": set_ or ()}
        _of_scenario(source, known, what_if, out, json)
    else:
        none_of(of_scenario, "applies to a scenario, and this is a log", "leave it out")
        known |= {"field_strength_nT": field_strength_nT, "field_enu_nT": field_vector(field_enu_nT)}
        with progress(f"bound of {Path(source).name}"):
            found = bound(source, **known, reading=reading, run=run or 0, out=out)
        _show(found, out, json)


def _of_scenario(source: str, known: dict[str, Any], what_if: str | None, out: Path | None, json: bool) -> None:
    from magbench.api.bound import bound
    from magbench.api.bound import what_if as bound_over
    from magbench.console import progress

    name = find(source).stem
    if not what_if:
        with progress(f"bound of {name}"):
            found = bound(source, **known, out=out)
        _show(found, out, json)
        return
    place = out or Path("out") / f"{name}-bound"
    with progress(f"bounds of {name}"):
        swept = bound_over(source, what_if, **known, out=place)
    _show_sweep(swept, place, json)


def _show(found: BoundResult, out: Path | None, json: bool) -> None:
    from magbench.console import emit, say, show_table, show_text
    from validation.bound.summary import HEADS, SCORE_HEADS, rows, score_rows, summary

    if json:
        emit(summary(found))
    else:
        show_text(f"{found!r}\n")
        show_table(PARAMETERS_TITLE, HEADS, rows(found))
        show_table("", SCORE_HEADS, score_rows(found.used), numbers=False)
    if out is not None:
        say(f"{out}: report.html, bound.json")


def _show_sweep(found: WhatIfResult, out: Path, json: bool) -> None:
    from magbench.console import emit, say, show_table, show_text
    from validation.bound.summary import what_if_heads, what_if_rows, what_if_summary

    if json:
        emit({"what_if": what_if_summary(found), "out": str(out)})
    else:
        show_text(f"{found!r}\n")
        show_table("", what_if_heads(found), what_if_rows(found))
    say(f"{out}: report.html, bound.json")
