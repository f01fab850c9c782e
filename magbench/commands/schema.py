"""`magbench schema`: the JSON Schema of scenario, gate and calibration files."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from magbench.options import Json


class SchemaKind(StrEnum):
    """What has a schema."""

    scenario = "scenario"
    calibration = "calibration"
    gates = "gates"


def command(
    kind: Annotated[SchemaKind, typer.Argument(help="Of which kind of file.")] = SchemaKind.scenario,
    json: Json = False,
) -> None:
    """Print the JSON Schema of scenario files or files of gates, for editors, or of a calibrator's result.

    Always as JSON, with or without --json.

    Example: magbench schema calibration > calibration.schema.json
    """
    from magbench.console import emit

    emit(_of(kind))


def _of(kind: SchemaKind) -> dict[str, object]:
    if kind is SchemaKind.calibration:
        from calib.schema import json_schema

        return json_schema()
    if kind is SchemaKind.gates:
        from validation.gates.gate_file import json_schema as gates_schema

        return gates_schema()
    from sim.scenario import json_schema as scenario_schema

    return scenario_schema()
