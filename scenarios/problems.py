"""Validation errors in one line: where, what, and the valid keys or kinds."""

from __future__ import annotations

from collections.abc import Iterable
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from scenarios.errors import InputError
from scenarios.names import closest

Path = tuple[str | int, ...]
_MISFIT = "misfit"


def dotted(path: Iterable[str | int]) -> str:
    """Return a dotted path such as phases.1.radius_m; a key with a dot is quoted."""
    return ".".join(f'"{part}"' if "." in str(part) else str(part) for part in path)


def misfit(path: Path, what: str, do: str = "") -> ValidationError:
    """Return the error by which a validator locates a problem below its own table, with advice."""
    cause = PydanticCustomError(_MISFIT, "{what}", {"what": what, "do": do})
    return ValidationError.from_exception_data(_MISFIT, [InitErrorDetails(type=cause, loc=path, input=None)])


def only_problem(error: ValidationError) -> tuple[Path, str, str]:
    """Return path, problem and advice of a `misfit`."""
    (problem,) = error.errors(include_url=False)
    return problem["loc"], problem["ctx"]["what"], problem["ctx"]["do"]


def first_problem(error: ValidationError, model: type[BaseModel]) -> tuple[Path, str, str]:
    """Return the first error, unknown keys before all else: path in the file, problem, advice.

    A misspelt key is also reported as missing, under the correct name; hence the order.
    """
    problems = error.errors(include_url=False)
    problem = min(problems, key=lambda p: p["type"] != "extra_forbidden")
    path, _ = _followed(model, problem["loc"])
    what, do = _words(problem, model)
    more = f"; and {len(problems) - 1} more" if len(problems) > 1 else ""
    return path, what + more, do


def problem_at(where: str, path: Path, what: str, do: str) -> InputError:
    """Return the InputError with file (or override) and key."""
    return InputError(what, where=": ".join(filter(None, (where, dotted(path)))), do=do)


def _words(problem: ErrorDetails, model: type[BaseModel]) -> tuple[str, str]:
    kind, given, loc = problem["type"], problem.get("input"), problem["loc"]
    if kind == _MISFIT:
        return problem["ctx"]["what"], problem["ctx"]["do"]
    if kind == "extra_forbidden":
        return "unknown key", closest(str(loc[-1]), _keys(_followed(model, loc[:-1])[1]))
    if kind == "missing":
        return "missing", "add it"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _wrong_kind(given, list(_kinds(_followed(model, loc)[1])))
    what = phrase(problem)
    whole = isinstance(given, dict) or kind == "value_error"
    return what, "an override with an empty value, --set KEY=, removes a key" if whole and "either" in what else ""


def phrase(problem: ErrorDetails) -> str:
    """Return pydantic's message as a phrase, with the value found if the value is short."""
    given = problem["input"]
    what = str(problem["msg"]).removeprefix("Value error, ").replace("\n", " ")
    what = (what[:1].lower() + what[1:]).replace("input should be", "must be")
    return what if isinstance(given, dict) or problem["type"] == "value_error" else f"{what}; found {_short(given)}"


def _wrong_kind(given: Any, kinds: list[str]) -> tuple[str, str]:
    tag = given.get("kind") if isinstance(given, dict) else None
    if tag is None:
        return "kind is missing", "one of " + ", ".join(kinds)
    return f'unknown kind "{tag}"', closest(str(tag), kinds, most=len(kinds))


def _short(given: Any) -> str:
    text = repr(given).replace("\n", " ")
    return text if len(text) <= 60 else text[:57] + "..."


def _followed(model: type[BaseModel], loc: Path) -> tuple[Path, Any]:
    """Return a location of pydantic as path in the file, without the kinds of tagged unions, and the type there."""
    path: list[str | int] = []
    found: Any = model
    for part in loc:
        kinds = _kinds(found)
        if part in kinds:
            found = kinds[str(part)]
            continue
        path.append(part)
        found = _bare(_inside(found, part))
    return tuple(path), found


def _inside(table: Any, part: str | int) -> Any:
    """Return the type under a key of a table, array or mapping; None if unknown."""
    fields = getattr(table, "model_fields", {})
    named = {info.alias or name: info.annotation for name, info in fields.items()}
    if named:
        return named.get(str(part))
    within = get_args(table)
    if get_origin(table) is dict:
        return within[1]
    return within[0] if get_origin(table) is tuple else None


def _bare(annotation: Any) -> Any:
    """Return a type without annotations, and an optional type without None."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    choices = [choice for choice in get_args(annotation) if choice is not NoneType]
    return choices[0] if NoneType in get_args(annotation) and len(choices) == 1 else annotation


def _kinds(found: Any) -> dict[str, type[BaseModel]]:
    """Return the tables of a tagged union by `kind`."""
    tables = [table for table in get_args(found) if "kind" in getattr(table, "model_fields", {})]
    words = {get_args(table.model_fields["kind"].annotation): table for table in tables}
    return {str(word[0]): table for word, table in words.items() if word}


def _keys(table: Any) -> list[str]:
    """Return the keys of a table as written in files."""
    return [info.alias or name for name, info in getattr(table, "model_fields", {}).items()]
