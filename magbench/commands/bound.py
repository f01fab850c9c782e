"""`magbench bound`: the accuracy that any method can reach, and what the motion cannot tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from magbench.arguments import field_vector
from magbench.options import FieldStrength, FieldVector, Json, Maps, Overrides
from scenarios.errors import InputError
from scenarios.names import find

if TYPE_CHECKING:
    from validation.bound.experiment import Experiment

Source = Annotated[
    str, typer.Argument(metavar="SCENARIO|DATA", help="A scenario's name or TOML file, a dataset or a log.")
]
Knowledge = Annotated[
    Literal["norm", "norm+gyro", "vector"],
    typer.Option(help="What a method is told of the field: strength, with a gyro, or the whole vector."),
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
StrengthUnknown = Annotated[
    bool,
    typer.Option("--strength-unknown", help="The strength is not known either: S up to a factor, its trace fixed."),
]
WhichRun = Annotated[int | None, typer.Option(min=0, help="Which run of a dataset directory.  [default: 0]")]


def bound(
    source: Source,
    knowledge: Knowledge = "norm",
    noise_std_nT: Noise = None,
    gyro_noise_rad_s: GyroNoise = None,
    strength_unknown: StrengthUnknown = False,
    set_: Overrides = None,
    run: WhichRun = None,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
    json: Json = False,
) -> None:
    """Tell the Cramer-Rao bound: the least errors of offset, matrix, heading; and what is not observable.

    Example: magbench bound auv-spiral --knowledge norm+gyro
    """
    path = find(source)
    if path.suffix == ".toml":
        _refuse_for_scenario(run, field_strength_nT, field_enu_nT, map_)
        known = _scenario(path, set_, noise_std_nT)
    else:
        _refuse({"--set": set_}, "speaks of a scenario, and this is a log", "leave it out")
        known = _log(path, noise_std_nT, run, map_, field_strength_nT, field_enu_nT)
    if gyro_noise_rad_s is not None:
        known = replace(known, gyro_std_rad_s=gyro_noise_rad_s)
    _tell(known, knowledge, json, strength_known=not strength_unknown)


def _scenario(path: Path, set_: list[str] | None, noise_std_nT: float | None) -> Experiment:
    from sim.scenario import load
    from validation.bound.files import scenario_experiment

    return scenario_experiment(load(path, set_ or ()), noise_std_nT)


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


def _refuse_for_scenario(run: int | None, strength_nT: float | None, enu: str | None, maps: list[str] | None) -> None:
    given = {"--run": run, "--field-strength-nT": strength_nT, "--field-enu-nT": enu, "--map": maps}
    _refuse(given, "speaks of a log, and this is a scenario", "change the scenario with --set KEY=VALUE")


def _refuse(given: Mapping[str, object], what: str, do: str) -> None:
    """Options that say nothing here; InputError for the first that is given."""
    for option, value in given.items():
        if value is not None:
            raise InputError(what, where=option, do=do)


def _tell(known: Experiment, knowledge: str, json: bool, *, strength_known: bool) -> None:
    from magbench.console import emit, say, show_table
    from validation.bound.answer import headline, rows, summary, use_rows
    from validation.bound.bound import Bound
    from validation.bound.uses import uses
    from validation.bound.weak import weak_directions

    found = Bound.of(known, knowledge, strength_known=strength_known)
    used, weak = uses(known, found), weak_directions(known, found)
    if json:
        emit(summary(known, found, used, weak))
    else:
        show_table("", ["axis", "offset, nT", "S x", "S y", "S z"], rows(found))
        show_table("", ["at least", "error", "of what"], use_rows(used), numbers=False)
    say(headline(known, found, weak))
