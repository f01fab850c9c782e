"""Validation errors told as one line: where, what, and the keys or kinds that would be valid."""

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
    """phases.1.radius_m; a key that holds a dot is quoted."""
    return ".".join(f'"{part}"' if "." in str(part) else str(part) for part in path)


def misfit(path: Path, what: str, do: str = "") -> ValidationError:
    """What a validator raises to name a place below its own, and what to do; told as it is."""
    cause = PydanticCustomError(_MISFIT, "{what}", {"what": what, "do": do})
    return ValidationError.from_exception_data(_MISFIT, [InitErrorDetails(type=cause, loc=path, input=None)])


def only_problem(error: ValidationError) -> tuple[Path, str, str]:
    """Path, what is wrong and what to do, of a `misfit`."""
    (problem,) = error.errors(include_url=False)
    return problem["loc"], problem["ctx"]["what"], problem["ctx"]["do"]


def first_problem(error: ValidationError, model: type[BaseModel]) -> tuple[Path, str, str]:
    """The most telling of the errors: its path in the file, what is wrong, and what to do.

    A misspelt key also leaves the key that was meant missing, so unknown keys are problem_at first.
    """
    problems = error.errors(include_url=False)
    problem = min(problems, key=lambda p: p["type"] != "extra_forbidden")
    path, _ = _followed(model, problem["loc"])
    what, do = _words(problem, model)
    more = f"; and {len(problems) - 1} more" if len(problems) > 1 else ""
    return path, what + more, do


def problem_at(where: str, path: Path, what: str, do: str) -> InputError:
    """The error with file (or override) and key."""
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
    """Pydantic's message as a phrase, with what was found where that is one value."""
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
    """Pydantic's location as the path in the file, without the kinds chosen in tagged unions; and the type there."""
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
    """The type of what a table, array or mapping holds under a key; None where that is not known."""
    fields = getattr(table, "model_fields", {})
    named = {info.alias or name: info.annotation for name, info in fields.items()}
    if named:
        return named.get(str(part))
    within = get_args(table)
    if get_origin(table) is dict:
        return within[1]
    return within[0] if get_origin(table) is tuple else None


def _bare(annotation: Any) -> Any:
    """A type without what annotates it, and without the None of an optional one."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    choices = [one for one in get_args(annotation) if one is not NoneType]
    return choices[0] if NoneType in get_args(annotation) and len(choices) == 1 else annotation


def _kinds(found: Any) -> dict[str, type[BaseModel]]:
    """The tables of a tagged union by their `kind`."""
    tables = [one for one in get_args(found) if hasattr(one, "model_fields") and "kind" in one.model_fields]
    words = {get_args(table.model_fields["kind"].annotation): table for table in tables}
    return {str(word[0]): table for word, table in words.items() if word}


def _keys(table: Any) -> list[str]:
    """The keys of a table as written in files."""
    return [info.alias or name for name, info in getattr(table, "model_fields", {}).items()]
