"""`magbench schema`: the JSON Schema of each file that is read, and of each result."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

from magbench.options import Json
from scenarios.errors import InputError
from scenarios.names import closest


class SchemaKind(StrEnum):
    """What has a schema; words describes it."""

    words: str

    def __new__(cls, key: str, words: str) -> SchemaKind:
        """Create a kind from key and words."""
        kind = str.__new__(cls, key)
        kind._value_, kind.words = key, words
        return kind

    SCENARIO = "scenario", "scenario file, as simulate, run and compare read: scenario.toml"
    GATES = "gates", "file of gates, as gate reads: gates.toml"
    CALIBRATION = "calibration", "calibration of one calibrator, as a command of --exec writes and apply reads"
    CALIBRATIONS = "calibrations", "calibration.json of calibrate: calibrations by name"
    CALIBRATIONS_IN_UNIT = "calibrations-in-unit", "calibration_in_UNIT.json of calibrate --unit-out"
    DATASET = "dataset", "dataset.json of simulate and run"
    RUN = "run", "run --json, scores.json"
    SIMULATE = "simulate", "simulate --json"
    COMPARE = "compare", "compare --json, comparison.json"
    GATE = "gate", "gate --json, gates.json"
    GATE_PROPOSAL = "gate-proposal", "gate --init --json"
    GATE_BASELINE = "gate-baseline", "gate --write-baseline --json"
    READ = "read", "read --json"
    RECHECK = "recheck", "recheck --json"
    CALIBRATE = "calibrate", "calibrate --json"
    APPLY = "apply", "apply --json"
    INSPECT = "inspect", "inspect --json, inspect.json"
    DIAGNOSE = "diagnose", "diagnose --json, diagnosis.json, of one recording"
    DIAGNOSE_SEVERAL = "diagnose-several", "the same of several recordings, or of an array's sensors"
    BOUND = "bound", "bound --json, bound.json"
    BOUND_WHAT_IF = "bound-what-if", "bound --what-if --json"
    PLAN = "plan", "plan --json, plan.json"
    PLAN_AFTER = "plan-after", "plan --after --json, plan.json"
    REPRODUCE = "reproduce", "reproduce --json, reproduction.json"
    SHOW = "show", "show --json"
    LIST = "list", "list --json, schema --json"


def command(
    kind: Annotated[
        str | None, typer.Argument(help="Of which file or result.  [default: a list of all]", metavar="KIND")
    ] = None,
    json: Json = False,
) -> None:
    """Print the JSON Schema of a file or of a command's --json.

    Without KIND all are listed.

    A schema is always JSON, with or without --json.

    Example: magbench schema calibration > calibration.schema.json
    """
    from magbench.console import emit, show_table

    if kind is not None:
        emit(schema_of(_kind(kind)))
    elif json:
        emit({"items": [{"name": one.value, "summary": one.words} for one in SchemaKind]})
    else:
        show_table("", ("kind", "of what"), [(one.value, one.words) for one in SchemaKind], numbers=False)


def _kind(name: str) -> SchemaKind:
    """Return the kind of a name; InputError for a name that is none."""
    known = {one.value: one for one in SchemaKind}
    if name not in known:
        raise InputError(f"no schema is called {name!r}", where="KIND", do=closest(name, known, most=len(known)))
    return known[name]


def schema_of(kind: SchemaKind) -> dict[str, Any]:
    """Return the JSON Schema of a kind."""
    match kind:
        case SchemaKind.SCENARIO:
            from sim.scenario import json_schema as of_scenarios

            return of_scenarios()
        case SchemaKind.GATES:
            from validation.gates.gate_file import json_schema as of_gates

            return of_gates()
        case SchemaKind.CALIBRATION:
            from calib.schema import json_schema as of_calibrations

            return of_calibrations()
    from reports.schemas import json_schema as of_results

    return of_results(kind.value)
