"""Validation errors told as one line: where, what, and the keys or kinds that would be valid."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from scenarios.errors import InputError
from scenarios.names import closest
from scenarios.paths import PHASES
from scenarios.spec import SensorSpec, Vary, VehicleSpec

Path = tuple[str | int, ...]
VEHICLES: dict[str, type[BaseModel]] = {
    get_args(cls.model_fields["kind"].annotation)[0]: cls for cls in get_args(get_args(VehicleSpec)[0])
}
"""Every kind of vehicle that a scenario file can name."""


def dotted(path: Iterable[str | int]) -> str:
    """phases.1.radius_m; a key that holds a dot is quoted."""
    return ".".join(f'"{part}"' if "." in str(part) else str(part) for part in path)


def first_problem(error: ValidationError, model: type[BaseModel]) -> tuple[Path, str, str]:
    """The most telling of the errors: its path in the file, what is wrong, and what to do.

    A misspelt key also leaves the key that was meant missing, so unknown keys are told first.
    """
    problems = error.errors(include_url=False)
    problem = min(problems, key=lambda p: p["type"] != "extra_forbidden")
    path = _without_tags(problem["loc"])
    what, do = _words(problem, model, path)
    more = f"; and {len(problems) - 1} more" if len(problems) > 1 else ""
    return path, what + more, do


def problem_at(where: str, path: Path, what: str, do: str) -> InputError:
    """The error with file (or override) and key."""
    return InputError(what, where=": ".join(filter(None, (where, dotted(path)))), do=do)


def _without_tags(loc: tuple[str | int, ...]) -> Path:
    """Drop what pydantic adds to the file's keys: the kind chosen in a tagged union."""
    match loc:
        case ("phases", int(index), str(kind), *rest) if kind in PHASES:
            return ("phases", index, *rest)
        case ("vehicle", str(kind), *rest) if kind in VEHICLES:
            return ("vehicle", *rest)
    return loc


def _words(problem: Any, model: type[BaseModel], path: Path) -> tuple[str, str]:
    kind, given = problem["type"], problem.get("input")
    if kind == "extra_forbidden":
        return "unknown key", closest(str(path[-1]), valid_keys(model, problem["loc"][:-1]))
    if kind == "missing":
        return "missing", "add it"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        kinds = PHASES if path[0] == "phases" else VEHICLES
        tag = given.get("kind") if isinstance(given, dict) else None
        if tag is None:
            return "kind is missing", "one of " + ", ".join(kinds)
        return f'unknown kind "{tag}"', closest(str(tag), kinds, most=len(kinds))
    what = str(problem["msg"]).removeprefix("Value error, ").replace("\n", " ")
    what = (what[:1].lower() + what[1:]).replace("input should be", "must be")
    if isinstance(given, dict) or kind == "value_error":
        return what, "an override with an empty value, --set KEY=, removes a key" if "either" in what else ""
    return f"{what}; found {_short(given)}", ""


def _short(given: Any) -> str:
    text = repr(given).replace("\n", " ")
    return text if len(text) <= 60 else text[:57] + "..."


def valid_keys(model: type[BaseModel], loc: tuple[str | int, ...]) -> list[str]:
    """The keys of the table at pydantic's location, as written in files."""
    match loc:
        case ("phases", _, str(kind)):
            table: Any = PHASES[kind]
        case ("vehicle", str(kind)):
            table = VEHICLES[kind]
        case ("sensors", _):
            table = SensorSpec
        case ("vary", _):
            table = Vary
        case (str(name),):
            annotation = model.model_fields[name].annotation
            table = next((a for a in (annotation, *get_args(annotation)) if hasattr(a, "model_fields")), None)
        case _:
            table = model
    return [field.alias or name for name, field in table.model_fields.items()] if table else []
