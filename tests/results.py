"""Results of commands held to their schemas."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from magbench.commands.schema import SchemaKind, schema_of

BY_OPTION = {
    "--what-if": "bound-what-if",
    "--after": "plan-after",
    "--init": "gate-proposal",
    "--write-baseline": "gate-baseline",
}
"""The kind of a result that an option changes."""
FILES = {
    "bound.json": "bound",
    "calibration.json": "calibrations",
    "comparison.json": "compare",
    "dataset.json": "dataset",
    "diagnosis.json": "diagnose",
    "gates.json": "gate",
    "inspect.json": "inspect",
    "plan.json": "plan",
    "reproduction.json": "reproduce",
    "scores.json": "run",
}
"""The kind of each file that a command writes."""


@cache
def validator(kind: str) -> Draft202012Validator:
    """Of a kind's schema."""
    return Draft202012Validator(schema_of(SchemaKind(kind)))


def check_printed(arguments: Sequence[str], printed: Any) -> None:
    """Fail where the `--json` of a command is not as its schema says."""
    command = "list" if arguments[0] == "schema" else arguments[0]
    kinds = [kind for option, kind in BY_OPTION.items() if option in arguments]
    if arguments[0] != "schema" or not set(arguments[1:]) & set(SchemaKind):
        validator((kinds or [_several(command, printed)])[0]).validate(printed)


def check_files(place: Path) -> None:
    """The same of every JSON file below a directory."""
    for file in place.rglob("*.json"):
        content = json.loads(file.read_text(encoding="utf-8"))
        validator(_several(FILES[file.name], content)).validate(content)


def _several(kind: str, content: Any) -> str:
    """A diagnosis of several recordings, or of sensors, has keys of its own."""
    return f"{kind}-several" if kind == "diagnose" and content.keys() & {"recordings", "sensors"} else kind
