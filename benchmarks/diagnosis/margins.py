"""Numbers of a policy that notice which of their comparisons another value would turn."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any

import numpy as np

from diagnosis.effort import Effort
from diagnosis.policy import STANDARD, Policy

Turned = set[tuple[str, float]]
"""Numbers by name, with the factor by which a comparison of theirs would have turned."""
LIMITS = [f.name for f in fields(Policy) if f.name not in {f.name for f in fields(Effort)}]
"""Names of the numbers that decide."""


class WatchedNumber(float):
    """A number that notes each comparison in a diagnosis that its value times a factor would turn.

    A product, quotient, sum or power with a plain number is watched too, and an array compared with either. What
    becomes of its value in a function, or in arithmetic with an array, is not.
    """

    __array_priority__ = 1e6  # an array or a numpy number on the left leaves the comparison to this class
    name: str
    at: Callable[[float], float]
    note: Callable[[str, Any], None]

    @classmethod
    def of(cls, name: str, at: Callable[[float], float], note: Callable[[str, Any], None]) -> WatchedNumber:
        """The number whose value at a factor is given; note(name, turns) is called with each comparison."""
        number = cls(at(1.0))
        number.name, number.at, number.note = name, at, note
        return number

    def _compared(self, other: Any, how: Callable[[Any, Any], Any]) -> Any:
        value = float(other) if isinstance(other, WatchedNumber) else other
        self.note(self.name, lambda factor: np.any(how(self.at(factor), value) != how(float(self), value)))
        return how(float(self), value)

    def __lt__(self, other: Any) -> Any:
        return self._compared(other, operator.lt)

    def __le__(self, other: Any) -> Any:
        return self._compared(other, operator.le)

    def __gt__(self, other: Any) -> Any:
        return self._compared(other, operator.gt)

    def __ge__(self, other: Any) -> Any:
        return self._compared(other, operator.ge)

    def _with(self, other: Any, how: Callable[[Any, Any], Any]) -> Any:
        if isinstance(other, np.ndarray):
            return how(float(self), other)
        value = float(other)
        return WatchedNumber.of(self.name, lambda factor: float(how(self.at(factor), value)), self.note)

    def __mul__(self, other: Any) -> Any:
        return self._with(other, operator.mul)

    def __add__(self, other: Any) -> Any:
        return self._with(other, operator.add)

    def __sub__(self, other: Any) -> Any:
        return self._with(other, operator.sub)

    def __truediv__(self, other: Any) -> Any:
        return self._with(other, operator.truediv)

    def __pow__(self, other: Any, modulo: None = None) -> Any:
        return self._with(other, operator.pow)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(other, lambda own, value: value / own)

    def __rsub__(self, other: Any) -> Any:
        return self._with(other, lambda own, value: value - own)

    __rmul__, __radd__ = __mul__, __add__

    def __reduce__(self) -> Any:
        return float, (float(self),)


@contextmanager
def watched_policy(factors: Sequence[float]) -> Iterator[tuple[Policy, Turned]]:
    """The standard policy with watched numbers, and the set of what would have turned, filled as it is used."""
    turned: Turned = set()

    def note(name: str, turns: Callable[[float], bool]) -> None:
        turned.update((name, factor) for factor in factors if (name, factor) not in turned and turns(factor))

    real = [name for name in LIMITS if isinstance(getattr(STANDARD, name), float)]
    watched: dict[str, Any] = {name: WatchedNumber.of(name, _times(getattr(STANDARD, name)), note) for name in real}
    yield replace(STANDARD, **watched), turned


def _times(value: float) -> Callable[[float], float]:
    return lambda factor: value * factor if math.isfinite(factor) else value
