"""How values differ from run to run: `[vary]` entries checked and drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from scenarios.names import closest
from scenarios.problems import first_problem, problem_at
from scenarios.spec import BaseScenario, Vary
from scenarios.toml import as_dict

Draw = Callable[[Vary], float]
S = TypeVar("S", bound=BaseScenario)


def apply_vary(scenario: S, rng: np.random.Generator) -> S:
    """The scenario of one run: every `vary` entry drawn, in sorted order of the keys; nothing is left to vary.

    Each component of a vector or matrix is drawn on its own. Without entries the scenario itself is returned and
    nothing is drawn. Raises InputError where a normal draw leaves the value's range.
    """
    if not scenario.vary:
        return scenario
    return _vary(scenario, lambda how: _draw(how, rng), "a draw is out of range: ")


def check_vary(scenario: BaseScenario, where: str) -> None:
    """Raise InputError unless every key names a number, vector or matrix, and both ends (or the mean) fit it."""
    if not scenario.vary:
        return
    for key, how in scenario.vary.items():
        if how.uniform and how.uniform[0] > how.uniform[1]:
            raise problem_at(where, ("vary", key), "uniform = [low, high] has low above high", "swap them")
        if how.normal and how.normal[1] < 0:
            raise problem_at(where, ("vary", key), "the standard deviation is negative", "normal = [mean, std]")
    for end in (0, 1):
        _vary(scenario, lambda how, end=end: how.uniform[end] if how.uniform else how.normal[0], "", where)  # type: ignore[misc]


def values_at(scenario: BaseScenario, keys: Iterable[str]) -> dict[str, Any]:
    """The scenario's values at dotted keys, such as those of `vary`; raises InputError for a key that is not there."""
    data = as_dict(scenario)
    found = {key: _find(data, key, scenario.name) for key in sorted(keys)}
    return {key: node[last] for key, (node, last) in found.items()}


def _draw(how: Vary, rng: np.random.Generator) -> float:
    if how.uniform:
        return float(rng.uniform(*how.uniform))
    assert how.normal is not None
    return float(rng.normal(*how.normal))


def _vary(scenario: S, draw: Draw, prefix: str, where: str = "") -> S:
    data = as_dict(scenario)
    for key in sorted(scenario.vary):
        node, last = _find(data, key, where)
        node[last] = _replace(node[last], scenario.vary[key], draw, key, where)
    data["vary"] = {}
    try:
        return type(scenario).model_validate(data)
    except ValidationError as error:
        path, what, _ = first_problem(error, type(scenario))
        raise problem_at(
            where, ("vary",), f"{prefix}{'.'.join(map(str, path))}: {what}", "narrow the distribution"
        ) from None


def _find(data: dict[str, Any], key: str, where: str) -> tuple[Any, Any]:
    """The table or array that holds the value, and its key there."""
    node: Any = data
    parts: list[str | int] = [int(part) if part.isdecimal() else part for part in key.split(".")]
    for depth, part in enumerate(parts):
        known = _keys(node)
        if part not in known or parts[0] in ("vary", "seed"):
            done = ".".join(map(str, parts[:depth])) or "the scenario"
            advice = closest(str(part), map(str, known))
            raise problem_at(where, ("vary", key), f'{done} has no value "{part}" to vary', advice)
        if depth < len(parts) - 1:
            node = node[part]
    return node, parts[-1]


def _keys(node: Any) -> list[Any]:
    if isinstance(node, list):
        return list(range(len(node)))
    return list(node) if isinstance(node, dict) else []


def _replace(value: Any, how: Vary, draw: Draw, key: str, where: str) -> Any:
    if isinstance(value, list) and value:
        return [_replace(item, how, draw, key, where) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise problem_at(where, ("vary", key), "not a number, vector or matrix", "name one of the scenario's numbers")
    return draw(how)
