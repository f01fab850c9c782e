"""A parameter of an effect: unit, range of the components, meaning, and role in a fit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal, get_args, get_origin

import numpy as np
from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, core_schema

from scenarios.errors import InputError

Vec3 = tuple[float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
_Time = Annotated[float, Field(ge=0.0, le=1e9, strict=True, allow_inf_nan=False)]
Window = Annotated[
    tuple[_Time, _Time] | None, Field(description="from when to when it acts, in the run's time; without: always [s]")
]
Role = Literal[
    "linear",
    "tangent",
    "listed",
    "moment",
    "place",
    "origin",
    "frequency",
    "period",
    "phase",
    "sweep",
    "motor",
    "channel",
    "level",
    "fixed",
    "free",
]
"""Role of a parameter in a fit.

=========  ==========================================================================================================
linear     the contribution is proportional to the parameter: least squares
tangent    the contributions of small values add up: least squares about zero, then refined
listed     a few values are tried (`tried`), then the best is refined between its neighbours
moment     a time of the run; every sample is tried, and the best is kept
place      a position beside the path; a grid is searched, then refined
origin     zero of a field linear in the position; found together with a constant
frequency  of a tone; the lines of a spectrum are searched, then refined
period     of a slow wave; the default, then the best of a spectrum where the run is long enough
phase      of a tone; spanned by a sine and a cosine
sweep      rate of change of a tone's frequency; changes by some cycles in a run are tried
motor      the number of a motor; each is tried
channel    the name of a channel; every channel of a recording is tried, after the effects with known causes
level      the size of a random disturbance, of each axis
fixed      a convention or a form (a reference, an extent): kept as given
free       refined from the given value
=========  ==========================================================================================================
"""
SEARCHED_ROLES = ("moment", "place", "origin", "frequency")
"""Roles that need a search of the whole recording, instead of a short list of values."""


@dataclass(frozen=True)
class Quantity:
    """Annotation of an effect's parameter: unit, range of each component, meaning and role.

    per_axis : a single number stands for all three axes. tried : first values of a fit ("listed"). units : values
    that span a linear parameter with dependent components; by default each component is free. form : name of the
    fuller form of the effect with this parameter; a fit tries the form once the effect is accepted.
    """

    unit: str
    low: float
    high: float
    doc: str
    role: Role = "free"
    per_axis: bool = False
    tried: tuple[float, ...] = ()
    units: tuple[Any, ...] = ()
    form: str = ""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        inner = handler.generate_schema(_ranged(source, self.low, self.high))
        return core_schema.no_info_before_validator_function(self._plain, inner)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        shown = handler.resolve_ref_schema(handler(schema))
        if self.per_axis:
            shown = {"anyOf": [shown, shown["prefixItems"][0]]}
        return shown | {"description": f"{self.doc} [{self.unit}]" if self.unit else self.doc}

    def _plain(self, value: Any) -> Any:
        """Arrays as tuples, a single number as three; a truth value is no number."""
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        if self.per_axis and isinstance(value, float | int) and not isinstance(value, bool):
            return (value, value, value)
        return value


@dataclass(frozen=True)
class OneOf:
    """Annotation of a parameter with a few words as values."""

    doc: str

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(schema) | {"description": self.doc}


@dataclass(frozen=True)
class ChannelName:
    """Annotation of a parameter that names a channel by column; the empty text names none."""

    doc: str

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(schema) | {"description": self.doc}


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect class: name, default and shape, with the annotation.

    `options`: the permitted words, if any. `several`: a number, or a list of numbers. `integer`: a count or an index.
    """

    name: str
    default: Any
    shape: tuple[int, ...]
    quantity: Quantity
    options: tuple[str, ...] = ()
    several: bool = False
    integer: bool = False

    @classmethod
    def of(cls, name: str, info: FieldInfo) -> Parameter:
        """The parameter of a field annotated with a `Quantity`, a `OneOf` or a `ChannelName`."""
        about = next(note for note in info.metadata if isinstance(note, Quantity | OneOf | ChannelName))
        if not isinstance(about, Quantity):
            role: Role = "fixed" if isinstance(about, OneOf) else "channel"
            words = Quantity("", 0.0, 0.0, about.doc, role=role)
            return cls(name, info.default, (), words, options=get_args(info.annotation))
        several = get_origin(info.annotation) is not tuple and bool(get_args(info.annotation))
        return cls(name, info.default, np.shape(info.default), about, several=several, integer=info.annotation is int)

    @property
    def unit(self) -> str:
        """Unit of the components, empty for a pure number."""
        return self.quantity.unit

    @property
    def low(self) -> float:
        """Least value of a component."""
        return self.quantity.low

    @property
    def high(self) -> float:
        """Greatest value of a component."""
        return self.quantity.high

    @property
    def doc(self) -> str:
        """Meaning."""
        return self.quantity.doc

    @property
    def role(self) -> Role:
        """Role in a fit."""
        return self.quantity.role

    @property
    def form(self) -> str:
        """Name of the fuller form of the parameter, empty for the plain form."""
        return self.quantity.form

    @property
    def worded(self) -> bool:
        """Whether the value is a word, without range or number."""
        return isinstance(self.default, str)

    @property
    def expected(self) -> str:
        """Description of a valid value, for messages."""
        if self.worded:
            return "one of " + ", ".join(self.options) if self.options else "the name of a channel"
        if self.integer:
            return "a whole number"
        if self.several:
            return "a number or a list of numbers"
        plain = {(): "a number", (2,): "two numbers", (3,): "three numbers", (3, 3): "three rows of three numbers"}[
            self.shape
        ]
        return f"a number or {plain}" if self.quantity.per_axis else plain


ACTIVE_WINDOW = Parameter("active_s", None, (2,), Quantity("s", 0.0, 1e9, "from when to when it acts", role="fixed"))
"""Parameter of every effect: the interval of activity, see `Effect.is_active`."""


def input_error(error: ValidationError, parameters: Sequence[Parameter], given: Mapping[str, Any]) -> InputError:
    """The first of pydantic's errors about the values given for an effect's parameters, as a line.

    `where` is the name of the parameter, empty where the parameters contradict each other.
    """
    problem = error.errors(include_url=False)[0]
    if not problem["loc"]:
        return InputError(str(problem["msg"]).removeprefix("Value error, "))
    first = problem["loc"][0]
    known = {p.name: p for p in parameters}
    name = list(known)[first] if isinstance(first, int) and first < len(known) else str(first)
    if name not in known:
        return InputError(
            f"no parameter {name!r}", do="it has " + ", ".join(one for one in known if one != ACTIVE_WINDOW.name)
        )
    return InputError(_what(known[name], problem, given[name]), where=name)


def _what(parameter: Parameter, problem: ErrorDetails, given: Any) -> str:
    found = problem["input"]
    if isinstance(found, float) and not math.isfinite(found):
        return f"expected finite numbers, found {found}"
    if problem["type"] in ("greater_than_equal", "less_than_equal"):
        unit = f" {parameter.unit}" if parameter.unit else ""
        return f"{found:g} is outside {parameter.low:g} to {parameter.high:g}{unit}"
    whole = given.tolist() if isinstance(given, np.ndarray | np.generic) else given
    return f"expected {parameter.expected}, found {whole!r}"


def _ranged(source: Any, low: float, high: float) -> Any:
    """The type with every number finite and in the range; values of a different type are refused, not converted."""
    if source is int:
        return Annotated[int, Field(ge=low, le=high, strict=True), BeforeValidator(_whole)]
    if source is float:
        return Annotated[float, Field(ge=low, le=high, strict=True, allow_inf_nan=False)]
    if get_origin(source) is not tuple:
        return reduce(or_, (_ranged(part, low, high) for part in get_args(source)))
    rows: Any = tuple
    if Ellipsis in get_args(source):
        return Annotated[rows[_ranged(get_args(source)[0], low, high), ...], Field(min_length=1)]
    return rows[tuple(_ranged(part, low, high) for part in get_args(source))]


def _whole(value: Any) -> Any:
    """2.0 as 2."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
