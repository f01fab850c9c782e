"""Hyperparameters: types with permitted values, and the check when a calibrator is made."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Annotated, Any, get_type_hints

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, create_model

from scenarios.errors import InputError
from scenarios.plain import plain
from scenarios.problems import dotted, phrase

Count = Annotated[int, Field(ge=1)]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Probability = Annotated[float, Field(ge=0, le=1)]


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError("the second must be greater than the first")
    return pair


Band = Annotated[tuple[Positive, Positive], AfterValidator(_rising)]
"""Lower and upper edge."""
_CONFIG = ConfigDict(strict=True, allow_inf_nan=False, arbitrary_types_allowed=True)


def check(settings: Any, where: str) -> None:
    """Raise InputError, with the field's name, for a value outside the type of a dataclass field, or not finite."""
    given = {item.name: _tuples(plain(getattr(settings, item.name))) for item in fields(settings)}
    kind: Any = type(settings)
    try:
        _schema(kind).model_validate(given)
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]
        raise InputError(phrase(problem), where=dotted((where, *problem["loc"]))) from None


@cache
def _schema(kind: type[Any]) -> type[BaseModel]:
    """The annotated fields of a dataclass, to check values by."""
    hints = get_type_hints(kind, include_extras=True)
    typed: dict[str, Any] = {item.name: (hints[item.name], ...) for item in fields(kind)}
    return create_model(kind.__name__, __config__=_CONFIG, **typed)


def _tuples(value: Any) -> Any:
    """Lists as tuples, at any depth."""
    return tuple(_tuples(part) for part in value) if isinstance(value, list) else value
