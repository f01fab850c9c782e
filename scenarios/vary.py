"""The variation of values from run to run: checks and draws of the `[vary]` entries."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from scenarios.distributions import Choice, Truncated
from scenarios.names import closest
from scenarios.problems import first_problem, problem_at
from scenarios.spec import BaseScenario
from scenarios.toml import as_dict
from scenarios.varied import Vary

Change = Callable[[Any, Vary], Any]
"""(value, entry) -> the replacement of the value."""
S = TypeVar("S", bound=BaseScenario)


def apply_vary(scenario: S, rng: np.random.Generator) -> S:
    """Return the scenario of a run: every `vary` entry drawn, in sorted order of the keys, and `vary` emptied.

    Without entries the scenario is returned unchanged and nothing is drawn. Raises InputError for a draw outside the
    value's range.
    """
    if not scenario.vary:
        return scenario
    return _vary(scenario, lambda value, how: _draw(value, how, rng), "a draw is out of range: ")


def check_vary(scenario: BaseScenario, where: str) -> None:
    """Raise InputError unless every key is a value of its distribution's shape, with extremes valid in the scenario.

    The extremes of an unbounded distribution lie `distributions.MOST_SIGMAS` standard deviations from the centre.
    """
    if not scenario.vary:
        return
    data = as_dict(scenario)
    ends: dict[str, tuple[Any, ...]] = {}
    for key in sorted(scenario.vary):
        node, last = _find(data, key, where)
        if last == "kind":
            do = "write a scenario for each kind"
            raise problem_at(where, ("vary", key), "a kind cannot vary: runs would hold other columns", do)
        ends[key] = _ends(node[last], scenario.vary[key], key, where)
    for number in range(max(map(len, ends.values()))):
        _put(scenario, {key: values[min(number, len(values) - 1)] for key, values in ends.items()}, "", where)


def values_at(scenario: BaseScenario, keys: Iterable[str]) -> dict[str, Any]:
    """Return the scenario's values at dotted keys, such as the keys of `vary`; InputError for an unknown key."""
    data = as_dict(scenario)
    found = {key: _find(data, key, scenario.name) for key in sorted(keys)}
    return {key: node[last] for key, (node, last) in found.items()}


def _draw(value: Any, how: Vary, rng: np.random.Generator) -> Any:
    distribution = how.distribution
    if isinstance(distribution, Choice):
        return distribution.draw(rng)
    with np.errstate(over="ignore"):  # an overflow is outside every range, and refused later
        return distribution.draw(np.array(value, dtype=np.float64), rng).tolist()


def _ends(value: Any, how: Vary, key: str, where: str) -> tuple[Any, ...]:
    """Return the extremes of a distribution, or all options of a choice."""
    distribution = how.distribution
    if isinstance(distribution, Choice):
        if any(isinstance(part, dict) for part in (value if isinstance(value, list) else [value])):
            raise problem_at(where, ("vary", key), "tables cannot vary as a whole", "name the values in them")
        return distribution.options
    numbers = _numbers(value)
    if numbers is None:
        raise problem_at(where, ("vary", key), "not a number, vector or matrix", "name one of the scenario's numbers")
    if problem := distribution.problem(numbers):
        raise problem_at(where, ("vary", key), problem, f"write {distribution.form}")
    with np.errstate(over="ignore"):
        return tuple(end.tolist() for end in distribution.ends(numbers))


def _numbers(value: Any) -> NDArray[np.float64] | None:
    """Return a number, vector or matrix of the scenario as an array; None for any other value."""
    try:
        plain = np.array(value)
    except ValueError:  # rows of unequal length
        return None
    return plain.astype(np.float64) if plain.dtype.kind in "if" else None


def _vary(scenario: S, change: Change, prefix: str) -> S:
    """Return the scenario with every varying value changed, in sorted order of the keys."""
    data = as_dict(scenario)
    changed = {}
    for key in sorted(scenario.vary):
        node, last = _find(data, key, "")
        changed[key] = change(node[last], scenario.vary[key])
    return _put(scenario, changed, prefix, "")


def _put(scenario: S, values: dict[str, Any], prefix: str, where: str) -> S:
    """Return the scenario with new values at their keys and `vary` emptied; InputError for an invalid value."""
    data = as_dict(scenario)
    for key, value in values.items():
        node, last = _find(data, key, where)
        node[last] = value
    data["vary"] = {}
    try:
        return type(scenario).model_validate(data)
    except ValidationError as error:
        path, what, _ = first_problem(error, type(scenario))
        do = f"narrow the distribution, or add {Truncated.form}"
        raise problem_at(where, ("vary",), f"{prefix}{'.'.join(map(str, path))}: {what}", do) from None


def _find(data: dict[str, Any], key: str, where: str) -> tuple[Any, Any]:
    """Return the table or array that holds the value of a dotted key, and the last part of the key."""
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
