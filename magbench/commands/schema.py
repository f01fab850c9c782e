"""`magbench schema`: the JSON Schema of scenario files, for editors."""

from __future__ import annotations

from magbench.options import Json


def schema(json: Json = False) -> None:
    """Print the JSON Schema of scenario files, for completion and checks in editors; with or without --json.

    Example: magbench schema > scenario.schema.json
    """
    from magbench.console import emit
    from sim.scenario import json_schema

    emit(json_schema())
