"""The entries of `[vary]` in a file: a distribution, with optional bounds or symmetry."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from scenarios.distributions import (
    Choice,
    Correlated,
    Distribution,
    LogNormal,
    LogUniform,
    Normal,
    OnSphere,
    RelativeNormal,
    Symmetric,
    Truncated,
    Uniform,
)
from scenarios.table import Table

_ROWS: dict[str, Any] = {"type": "number"}
for _ in range(2):
    _ROWS = {"anyOf": [{"type": "number"}, {"type": "array", "items": _ROWS, "minItems": 1}]}


def _numbers(given: Any) -> Any:
    """Return a finite number, or rows of equal length as tuples; ValueError otherwise."""
    if isinstance(given, list | tuple) and given:
        rows = tuple(map(_numbers, given))
        if len({np.shape(row) for row in rows}) > 1:
            raise ValueError("the rows are not equally long")
        return rows
    if isinstance(given, bool) or not isinstance(given, int | float) or not math.isfinite(given):
        raise ValueError(f"expected numbers, found {given!r}")
    return float(given)


def _one_or_two(radius: Any) -> Any:
    """Return a radius, or a pair of ends; ValueError for any other shape."""
    if np.shape(radius) not in ((), (2,)):
        raise ValueError("expected a radius, or [low, high]")
    return radius


Numbers = Annotated[Any, AfterValidator(_numbers), WithJsonSchema(_ROWS)]
"""A number for all components, or numbers in the shape of the value."""
Pair = tuple[Numbers, Numbers]


class CorrelatedSpec(Table):
    """Mean and covariance of the components together."""

    mean: Numbers
    covariance: Numbers


class Vary(Table):
    """The variation of a value from run to run: exactly one distribution, drawn once a run.

    The components of a vector or matrix are drawn independently, except by `on_sphere`, `correlated` and `choice`.
    """

    uniform: Pair | None = Field(None, description="low, high")
    normal: Pair | None = Field(None, description="mean, standard deviation")
    log_uniform: Pair | None = Field(None, description="low, high, both above zero: the logarithm is uniform")
    log_normal: Pair | None = Field(None, description="median, standard deviation of the natural logarithm")
    relative_normal: Numbers | None = Field(None, description="std s: the scenario's value times 1 + s n")
    on_sphere: Annotated[Numbers, AfterValidator(_one_or_two)] | None = Field(
        None, description="length of a vector of uniform direction; [low, high]: uniform between them"
    )
    correlated: CorrelatedSpec | None = Field(None, description="mean and covariance of all components together")
    choice: tuple[Any, ...] | None = Field(None, min_length=1, description="equally likely values; also text and dates")
    truncated: Pair | None = Field(None, description="low, high: components outside are drawn again")
    symmetric: Literal[True] | None = Field(None, description="a square matrix, its upper triangle repeated below")

    @model_validator(mode="after")
    def _one(self) -> Vary:
        given = [name for name in _MADE if getattr(self, name) is not None] + ["choice"] * (self.choice is not None)
        if len(given) != 1:
            forms = ", ".join((*_FORMS, Choice.form))
            raise ValueError(f"give {forms}: one of them, found {', '.join(given) or 'none'}")
        if self.choice is not None and (self.truncated is not None or self.symmetric):
            raise ValueError("a choice is neither truncated nor symmetric")
        return self

    @property
    def distribution(self) -> Distribution | Choice:
        """The distribution of the entry."""
        if self.choice is not None:
            return Choice(self.choice)
        made = next(make(getattr(self, name)) for name, make in _MADE.items() if getattr(self, name) is not None)
        if self.symmetric:
            made = Symmetric(made)
        return made if self.truncated is None else Truncated(made, *map(np.array, self.truncated))


def _of_pair(kind: Callable[..., Distribution]) -> Callable[[Any], Distribution]:
    return lambda pair: kind(np.array(pair[0]), np.array(pair[1]))


def _on_sphere(radius: Any) -> Distribution:
    low, high = np.array(radius).flat[[0, -1]]
    return OnSphere(low, high)


_MADE: dict[str, Callable[[Any], Distribution]] = {
    "uniform": _of_pair(Uniform),
    "normal": _of_pair(Normal),
    "log_uniform": _of_pair(LogUniform),
    "log_normal": _of_pair(LogNormal),
    "relative_normal": lambda std: RelativeNormal(np.array(std)),
    "on_sphere": _on_sphere,
    "correlated": lambda spec: Correlated(np.array(spec.mean), np.array(spec.covariance)),
}
_FORMS = tuple(kind.form for kind in (Uniform, Normal, LogUniform, LogNormal, RelativeNormal, OnSphere, Correlated))
