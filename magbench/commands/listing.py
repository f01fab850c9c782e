"""`magbench list`: effects, calibrators, scenarios, vehicles, sensors with a line each."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from magbench.options import Json


class ListKind(StrEnum):
    """What can be listed."""

    effects = "effects"
    calibrators = "calibrators"
    scenarios = "scenarios"
    vehicles = "vehicles"
    sensors = "sensors"


def command(kind: Annotated[ListKind, typer.Argument(help="What to list.")], json: Json = False) -> None:
    """List scenarios, effects, calibrators, vehicles or sensors with a line each.

    Example: magbench list scenarios
    """
    from magbench.console import emit, show_table

    items = _items(kind)
    if json:
        emit({"items": [{"name": name, "summary": summary} for name, summary in items.items()]})
    else:
        show_table("", (kind.value[:-1], "summary"), list(items.items()), numbers=False)


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

    return {cls.name: summary(cls.name) for cls in EFFECTS}
