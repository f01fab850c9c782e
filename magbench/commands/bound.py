"""`magbench bound`: the accuracy that any method can reach, and what the motion cannot tell."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from magbench.arguments import field_vector
from magbench.options import FieldStrength, FieldVector, Json, Maps, Overrides, Run
from scenarios.names import find

Knowledge = Literal["norm", "norm+gyro", "vector"]


def bound(
    source: Annotated[
        str, typer.Argument(metavar="SCENARIO|DATA", help="A scenario's name or TOML file, a dataset or a log.")
    ],
    knowledge: Annotated[
        Knowledge, typer.Option(help="What a method is told of the field: strength, with a gyro, or the whole vector.")
    ] = "norm",
    noise_std_nT: Annotated[
        float | None,
        typer.Option("--noise-std-nT", min=1e-9, help="White noise of each axis.  [default: as found in the data]"),
    ] = None,
    set_: Overrides = None,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
    json: Json = False,
) -> None:
    """Tell the Cramer-Rao bound: the least standard deviations of offset and matrix, and what is not observable.

    Example: magbench bound auv-spiral --knowledge norm+gyro
    """
    path, enu = find(source), field_vector(field_enu_nT)
    from magbench.console import emit, say, show_table
    from sim.scenario import load
    from validation.bound.answer import headline, rows, summary
    from validation.bound.bound import Bound
    from validation.bound.files import recording_experiment, scenario_experiment
    from validation.bound.weak import weak_directions

    if path.suffix == ".toml":
        known = scenario_experiment(load(path, set_ or ()), noise_std_nT)
    else:
        known = recording_experiment(
            path, noise_std_nT=noise_std_nT, run=run, maps=map_ or (), strength_nT=field_strength_nT, enu=enu
        )
    found = Bound.of(known, knowledge)
    weak = weak_directions(known, found)
    if json:
        emit(summary(known, found, weak))
    else:
        show_table("", ["axis", "offset, nT", "S x", "S y", "S z"], rows(found))
    say(headline(known, found, weak))
