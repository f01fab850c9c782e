"""`magbench list`: effects, calibrators, scenarios, vehicles, sensors with a line each."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from magbench.options import Json
from scenarios.errors import InputError


class ListKind(StrEnum):
    """What can be listed."""

    effects = "effects"
    calibrators = "calibrators"
    scenarios = "scenarios"
    vehicles = "vehicles"
    sensors = "sensors"


def command(
    kind: Annotated[ListKind, typer.Argument(help="What to list.")],
    name: Annotated[str | None, typer.Argument(help="A calibrator, whose options are listed.")] = None,
    json: Json = False,
) -> None:
    """List scenarios, effects, calibrators, vehicles or sensors. Of a calibrator, its options.

    Example: magbench list calibrators ml_geometric
    """
    from magbench.console import emit, show_table

    items = _items(kind) if name is None else _options(kind, name)
    if json:
        emit({"items": [{"name": name, "summary": summary} for name, summary in items.items()]})
    else:
        show_table("", (kind.value[:-1] if name is None else "option", "summary"), list(items.items()), numbers=False)


def _options(kind: ListKind, name: str) -> dict[str, str]:
    """Return the options of a calibrator, with default and permitted values."""
    if kind is not ListKind.calibrators:
        raise InputError(f"{kind.value} have no options", where=name, do=f"magbench list {kind.value}")
    from calib import get
    from calib.options import options_of

    return {key: f"{default}; {permitted}" for key, (default, permitted) in options_of(type(get(name))).items()}


def _items(kind: ListKind) -> dict[str, str]:
    if kind is ListKind.scenarios:
        from scenarios.load import catalogue

        return catalogue()
    if kind is ListKind.calibrators:
        from validation.calibrating.selection import known_names

        return known_names()
    if kind is ListKind.vehicles:
        from sim.vehicles import VEHICLES

        return {name: cls.summary for name, cls in VEHICLES.items()}
    if kind is ListKind.sensors:
        from sim.sensors import SENSORS

        return {name: sensor.summary for name, sensor in SENSORS.items()}
    from sim.effects import EFFECTS, summary

    return {cls.name: summary(cls.name).replace("``", "") for cls in EFFECTS}
