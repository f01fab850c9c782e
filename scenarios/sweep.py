"""The option `--sweep key=1,5,10` or `key=0:30:5`: a value of the scenario that takes several values in turn."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeVar

from pydantic import ValidationError

from scenarios.errors import InputError
from scenarios.names import closest
from scenarios.overrides import parse
from scenarios.problems import first_problem
from scenarios.spec import BaseScenario
from scenarios.toml import as_dict
from scenarios.vary import check_vary

Value = float | str | bool
S = TypeVar("S", bound=BaseScenario)
OPTION = "--sweep"
FIXED = ("name", "summary", "seed", "calibrators", "vary")
"""Keys of a scenario without influence on the simulation, which cannot be swept."""
NUMBER = r"\s*([+-]?\d{1,12}(?:\.\d{0,12})?)\s*"
RANGE = re.compile(f"{NUMBER}:{NUMBER}:{NUMBER}", re.ASCII)
MOST_VALUES = 1000
"""The largest number of values in a range."""
MOST_NEAR = 8
"""The largest number of keys in advice."""


@dataclass(frozen=True)
class Sweep:
    """A value of a scenario, by its dotted key, and the values to take in turn."""

    key: str
    values: tuple[Value, ...]


def parse_sweep(text: str, scenario: BaseScenario, option: str = OPTION) -> Sweep:
    """Parse `KEY=1,5,10` or `KEY=0:30:5`; KEY is a dotted key of the scenario, or a unique ending of a key.

    `noise_std_nT` ends `effects.white_noise.std_nT`: underscores may replace the dots of a key.
    Raises InputError for an unknown key, listing the nearest, for an ambiguous key, for values that are neither numbers
    nor words, for repeated values, and for a key that `[vary]` draws in each run.
    """
    where = f"{option} {text}"
    name, equals, values = (part.strip() for part in text.partition("="))
    words = _range(values, where) or [word.strip() for word in values.split(",")]
    if not (equals and name and all(words)):
        raise InputError("not a key and its values", where=where, do=f"write {option} noise_std_nT=1,5,10 or 0:30:5")
    key = _full_key(name, scenario, where)
    found = tuple(_value(key, word, where) for word in words)
    if len(set(found)) < len(found):
        raise InputError("a value stands there twice", where=where, do="give each value once")
    _check_not_drawn(key, scenario, where)
    return Sweep(key, found)


def _range(text: str, where: str) -> list[str]:
    """Return the numbers of START:STOP:STEP, both ends included, as text; empty for a text that is no range."""
    found = RANGE.fullmatch(text)
    if not found:
        return []
    start, stop, step = (Decimal(part) for part in found.groups())
    steps = (stop - start) / step if step else Decimal(-1)
    if not 0 <= steps < MOST_VALUES:
        do = f"write START:STOP:STEP with at most {MOST_VALUES} values"
        raise InputError("a range that leads nowhere, or too many values", where=where, do=do)
    return [str(start + step * number) for number in range(int(steps) + 1)]


def points(sweeps: Sequence[Sweep]) -> list[dict[str, Value]]:
    """Return every combination of the values, by key, the last key fastest; without sweeps one empty combination."""
    keys = [sweep.key for sweep in sweeps]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    if twice:
        raise InputError("is swept twice", where=f"--sweep {twice[0]}", do="give all its values in one --sweep")
    return [dict(zip(keys, values, strict=True)) for values in itertools.product(*(one.values for one in sweeps))]


def swept(scenario: S, values: Mapping[str, Value], option: str = OPTION) -> S:
    """Return the scenario with values at their keys; a number fills a vector. InputError for an unsuitable value."""
    data = deepcopy(as_dict(scenario))
    for key, value in values.items():
        _put(data, key, value, option)
    where = f"{option} " + ", ".join(f"{key}={value}" for key, value in values.items())
    try:
        changed = type(scenario).model_validate(data)
    except ValidationError as error:
        path, what, do = first_problem(error, type(scenario))
        place = ".".join(map(str, path))
        raise InputError(f"{place}: {what}", where=where, do=do or "give values that fit") from None
    check_vary(changed, where)
    return changed


def _full_key(name: str, scenario: BaseScenario, where: str) -> str:
    keys = [key for key, _ in _values(as_dict(scenario)) if key.split(".")[0] not in FIXED]
    if name in keys:
        return name
    ending = "_" + name.replace(".", "_")
    matching = [key for key in keys if ("_" + key.replace(".", "_")).endswith(ending)]
    if len(matching) == 1:
        return matching[0]
    if matching:
        do = "name one of " + ", ".join(matching)
        raise InputError(f"{len(matching)} values of the scenario end in {name}", where=where, do=do)
    raise InputError(f"the scenario has no value {name}", where=where, do=_near(name, keys))


def _near(name: str, keys: Sequence[str]) -> str:
    """Return advice with the keys that contain the name, or else with the keys of similar spelling."""
    inside = [key for key in keys if name.replace(".", "_") in key.replace(".", "_")]
    return "did you mean " + " or ".join(inside[:MOST_NEAR]) + "?" if inside else closest(name, keys)


def _values(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every number and word with its dotted key; a vector or matrix first whole, then by component."""
    if isinstance(node, dict | list):
        parts = node.items() if isinstance(node, dict) else enumerate(node)
        if key and isinstance(node, list) and not any(isinstance(part, dict) for part in node):
            yield key, node
        for part, value in parts:
            yield from _values(value, f"{key}.{part}" if key else str(part))
    else:
        yield key, node


def _value(key: str, word: str, where: str) -> Value:
    value = parse(f"{key}={word}").value
    if isinstance(value, list | dict):
        raise InputError(f"{word} is neither a number nor a word", where=where, do="write --sweep noise_std_nT=1,5,10")
    return value if isinstance(value, int | float | str) else word  # a date as it is written


def _put(data: dict[str, Any], key: str, value: Value, option: str) -> None:
    node: Any = data
    *path, last = (int(part) if part.isdecimal() else part for part in key.split("."))
    for part in path:
        node = node[part]
    node[last] = _filled(node[last], value, key, option)


def _filled(there: Any, value: Value, key: str, option: str) -> Any:
    if not isinstance(there, list):
        return value
    if any(isinstance(part, list) for part in there):
        do = f"name one of its components: {key}.0.0"
        raise InputError("is a matrix, which one number cannot fill", where=f"{option} {key}", do=do)
    return [value for _ in there]


def _check_not_drawn(key: str, scenario: BaseScenario, where: str) -> None:
    for drawn in scenario.vary:
        if f"{key}.".startswith(f"{drawn}.") or f"{drawn}.".startswith(f"{key}."):
            do = f"leave it out of [vary]: --set 'vary.\"{drawn}\"='"
            raise InputError(f"[vary] draws {drawn} anew in each run", where=where, do=do)
