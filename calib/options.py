"""Hyperparameters of a calibrator as text: `NAME:OPTION=VALUE:...`, as on a command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic.fields import FieldInfo

from calib.base import Calibrator
from scenarios.errors import InputError

SEPARATOR = ":"
WORDS: dict[str, bool | None] = {"yes": True, "no": False, "true": True, "false": False, "none": None}
KINDS = {bool: "yes or no", int: "a whole number", float: "a number", NoneType: "none", tuple: "numbers with / between"}


def configured(method: type[Calibrator], options: Sequence[str]) -> Calibrator:
    """The calibrator with options OPTION=VALUE; a bare word selects a value that an option has, or switches it on.

    Raises InputError for an unknown option, listing those there are, and for a value outside its type.
    """
    values: dict[str, Any] = {}
    hints = _hints(method)
    for text in options:
        option, equals, value = text.partition("=")
        name = option if equals else _selected(hints, text)
        if name not in hints:
            known = ", ".join(f"{one}={default}" for one, (default, _) in options_of(method).items())
            raise InputError(f"{method.name} has no option {text!r}", where=method.name, do=f"options: {known}")
        values[name] = _value(value) if equals else _bare(hints[name], text)
    return method(**values)


def options_of(method: type[Calibrator]) -> dict[str, tuple[str, str]]:
    """Default and permitted values of each option, as text."""
    hints = _hints(method)
    return {
        one.name: (_text(one.default), " or ".join(dict.fromkeys(_permitted(hints[one.name]))))
        for one in fields(method)
        if one.name in hints
    }


def _hints(method: type[Calibrator]) -> dict[str, Any]:
    """Type of each hyperparameter that a text can state."""
    hints = get_type_hints(method, include_extras=True)
    stated = [one for one in fields(method) if one.default is not MISSING and not is_dataclass(one.default)]
    return {one.name: hints[one.name] for one in stated}


def _value(text: str) -> Any:
    """A truth value, number, tuple of numbers, nothing, or the text itself."""
    if "/" in text:
        return tuple(_value(part) for part in text.split("/"))
    if text.lower() in WORDS:
        return WORDS[text.lower()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _text(value: Any) -> str:
    """A value as an option states it."""
    if isinstance(value, tuple):
        return "/".join(_text(part) for part in value)
    if isinstance(value, float):
        return f"{value:g}"
    return next((word for word, meant in WORDS.items() if meant is value), str(value))


def _selected(hints: dict[str, Any], word: str) -> str:
    """The option that has a word as a value; the word itself where it is an option or unknown."""
    return next((name for name, hint in hints.items() if word in _literals(hint)), word)


def _bare(hint: Any, word: str) -> Any:
    """The value that an option gets from a bare word: the word, the option's usual value, or yes."""
    if word in _literals(hint):
        return word
    if hint is bool:
        return True
    usual = [info.examples[0] for info in _infos(hint) if info.examples]
    if not usual:
        raise InputError(f"{word} needs a value", do=f"{word}=..., {' or '.join(dict.fromkeys(_permitted(hint)))}")
    return usual[0]


def _literals(hint: Any) -> list[Any]:
    if get_origin(hint) is Literal:
        return list(get_args(hint))
    return [value for part in _parts(hint) for value in _literals(part)]


def _infos(hint: Any) -> Iterator[FieldInfo]:
    """Constraints and examples of a type."""
    if get_origin(hint) is Annotated:
        yield from (part for part in get_args(hint)[1:] if isinstance(part, FieldInfo))
    for part in _parts(hint):
        yield from _infos(part)


def _parts(hint: Any) -> tuple[Any, ...]:
    """Types that an annotation or a union is made of."""
    origin = get_origin(hint)
    if origin is Annotated:
        return get_args(hint)[:1]
    return get_args(hint) if origin in (Union, UnionType) else ()


def _permitted(hint: Any) -> list[str]:
    """Permitted values in words."""
    if get_origin(hint) is Literal:
        return [_text(value) for value in get_args(hint)]
    if parts := _parts(hint):
        return [word for part in parts for word in _permitted(part)]
    return [KINDS.get(get_origin(hint) or hint, "text")]
