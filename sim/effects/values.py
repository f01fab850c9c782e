"""A parameter of an effect: what it means, what values it takes, and the check of a value a user wrote."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """Name, unit, bounds of each component, shape, default and meaning of one parameter.

    `options`: the words that it takes, if it takes words. `per_axis`: one number may stand for all three axes.
    `several`: a number, or any number of them.
    """

    name: str
    unit: str
    low: float
    high: float
    shape: tuple[int, ...]
    default: Any
    doc: str
    options: tuple[str, ...] = ()
    per_axis: bool = False
    several: bool = False

    @classmethod
    def of(cls, name: str, default: Any, notes: Mapping[str, Any]) -> Parameter:
        """The parameter of a dataclass field made by `sim.effects.base.parameter` or `choice`."""
        if "options" in notes:
            return cls(name, "", 0.0, 0.0, (), default, notes["doc"], notes["options"])
        return cls(name=name, default=default, shape=np.shape(default), **notes)

    @property
    def integer(self) -> bool:
        """A count or an index."""
        return isinstance(self.default, int)

    @property
    def expected(self) -> str:
        """What a value looks like, for messages."""
        if self.options:
            return "one of " + ", ".join(self.options)
        if self.integer:
            return "a whole number"
        if self.several:
            return "a number or a list of numbers"
        plain = {(): "a number", (3,): "three numbers", (3, 3): "three rows of three numbers"}[self.shape]
        return f"a number or {plain}" if self.per_axis else plain

    def checked(self, value: Any, where: str) -> Any:
        """The value as floats in tuples (or the word, or the whole number); InputError if it is not one."""
        if self.options:
            return self._word(value, where)
        plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        numbers = self._numbers(plain, where, plain)
        if self.per_axis and isinstance(numbers, float):
            numbers = (numbers, numbers, numbers)
        if not self._fits(numbers):
            raise self._wrong(plain, where)
        if not self.integer:
            return numbers
        if numbers != int(numbers):
            raise self._wrong(plain, where)
        return int(numbers)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the values."""
        about = {"description": " ".join(filter(None, (self.doc, f"[{self.unit}]" if self.unit else "")))}
        if self.options:
            return {**about, "enum": list(self.options), "default": self.default}
        kind = "integer" if self.integer else "number"
        number: dict[str, Any] = {"type": kind, "minimum": self.low, "maximum": self.high}
        shaped = number
        for size in reversed(self.shape):
            shaped = {"type": "array", "items": shaped, "minItems": size, "maxItems": size}
        forms = [number] if self.per_axis else []
        forms += [{"type": "array", "items": number, "minItems": 1}] if self.several else []
        return {**about, "default": self.default, **({"anyOf": [shaped, *forms]} if forms else shaped)}

    def _word(self, value: Any, where: str) -> str:
        if isinstance(value, str) and value in self.options:
            return value
        raise self._wrong(value, where)

    def _numbers(self, value: Any, where: str, whole: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(self._numbers(part, where, whole) for part in value)
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong(whole, where)
        if not math.isfinite(value):
            raise InputError(f"expected finite numbers, found {value}", where=where)
        if not self.low <= value <= self.high:
            unit = f" {self.unit}" if self.unit else ""
            raise InputError(f"{value:g} is outside {self.low:g} to {self.high:g}{unit}", where=where)
        return float(value)

    def _fits(self, numbers: Any) -> bool:
        shape = _shape(numbers)
        return shape == self.shape or (self.several and shape is not None and len(shape) <= 1 and shape != (0,))

    def _wrong(self, value: Any, where: str) -> InputError:
        return InputError(f"expected {self.expected}, found {value!r}", where=where)


def _shape(value: Any) -> tuple[int, ...] | None:
    if not isinstance(value, tuple):
        return ()
    inner = {_shape(part) for part in value}
    if not value:
        return (0,)
    if len(inner) > 1 or None in inner:
        return None
    return (len(value), *(inner.pop() or ()))
