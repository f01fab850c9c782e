"""An effect: a frozen class of parameters, injected by the simulator, labelled in datasets, proposed by a diagnosis."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import Field
from typing import Any, ClassVar, Literal, Self, TypeVar, cast, dataclass_transform

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, ValidationError
from pydantic.dataclasses import dataclass
from pydantic.fields import FieldInfo

from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.parameters import ACTIVE_WINDOW, SEARCHED_ROLES, Mat3, Parameter, Role, Vec3, Window, input_error
from sim.effects.traits import Traits
from sim.state import State

ZERO3: Vec3 = (0.0, 0.0, 0.0)
ZERO33: Mat3 = (ZERO3, ZERO3, ZERO3)
Memory = dict[str, Any]
Stage = Literal["field", "vehicle", "sensor", "electronics"]
_STRICT = ConfigDict(extra="forbid", field_title_generator=lambda name, _: name)
E = TypeVar("E", bound="Effect")
PLAIN = ""
"""The form of every effect, see `Quantity.form`."""
SMALL = 0.01
"""A small value of a tangent parameter, in the parameter's unit: contributions add up."""


def array(values: Vec3 | Mat3 | float | tuple[float, ...]) -> Array:
    """A parameter's value as an array."""
    return np.array(values, dtype=np.float64)


@dataclass_transform(frozen_default=True)
def frozen(cls: type[E]) -> type[E]:
    """Make an effect of a class: annotated parameters become the checked fields of a frozen dataclass.

    Values are checked when an effect is made and kept as floats in tuples; InputError names the wrong parameter.
    """
    made = cast("type[E]", dataclass(frozen=True, config=_STRICT)(cls))
    made.describe_parameters()
    fill = made.__init__

    def __init__(self: E, *args: Any, **values: Any) -> None:
        try:
            fill(self, *args, **values)
        except ValidationError as error:
            known = (*self.parameters(), ACTIVE_WINDOW)
            given = {p.name: value for p, value in zip(known, args, strict=False)} | values
            problem = input_error(error, known, given)
            place = ".".join(filter(None, (self.name, problem.where)))
            raise InputError(problem.what, where=place, do=problem.do) from None

    setattr(made, "__init__", __init__)  # noqa: B010, the type checker knows the fields
    return made


@dataclasses.dataclass(frozen=True, kw_only=True)
class Effect(ABC):
    """A disturbance: a class decorated with `frozen`, whose fields are physical parameters with the unit in the name.

    ``signal_out = signal_in + apply(state, signal_in, rng, memory)``; the contribution is stored as the effect's label.
    With `active_s` = (t_0, t_1) the contribution is zero outside t_0 <= t < t_1.

    A parameter is a field annotated with a `Quantity` (unit, range, meaning, role), a `OneOf` (a word) or a
    `ChannelName`, and has a default; with all defaults the effect does nothing. The role of a parameter tells a fit how
    to determine the value, see `parameters.Role`.

    =============  =================================================================================================
    name           key of the effect in scenarios, labels and reports
    stage          place in the chain: field, vehicle, sensor or electronics
    needs          inputs of the motion ("attitude", "rate", "position"), and channels by column
    example        parameters with which the effect acts, for tests and documentation
    traits         identifiability and remedy, see `Traits`
    stochastic     the contribution is random
    static         field, channels and time of one instant determine the contribution, so a calibration can remove it
    continuous     the field between the samples determines the contribution, so the simulator computes every step
    =============  =================================================================================================
    """

    name: ClassVar[str]
    stage: ClassVar[Stage]
    example: ClassVar[Mapping[str, Any]]
    traits: ClassVar[Traits] = Traits()
    needs: ClassVar[tuple[str, ...]] = ()
    stochastic: ClassVar[bool] = False
    static: ClassVar[bool] = False
    continuous: ClassVar[bool] = False

    linear: ClassVar[tuple[str, ...]]
    """Names of the linear parameters, the columns of `basis`."""
    search: ClassVar[dict[str, tuple[float, ...]]]
    """The values to try of each listed parameter."""
    forms: ClassVar[dict[str, tuple[Parameter, ...]]]
    """The parameters of each fuller form, in the order of the class."""
    tangents: ClassVar[dict[str, tuple[Vec3, ...]]]
    """A small value of each tangent parameter along each component."""

    _parameters: ClassVar[tuple[Parameter, ...]]
    _spans: ClassVar[dict[str, Array]]
    __pydantic_fields__: ClassVar[dict[str, FieldInfo]]
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    active_s: Window = None

    def __post_init__(self) -> None:
        if self.active_s is not None and self.traits.whole_run:
            raise ValueError(f"{ACTIVE_WINDOW.name} is not for {self.name}: it is a course of the whole run")
        if self.active_s is not None and self.active_s[0] >= self.active_s[1]:
            raise ValueError(f"{ACTIVE_WINDOW.name} must end after it begins, found {list(self.active_s)}")
        if problem := self.problem():
            raise ValueError(problem)

    @abstractmethod
    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution (n, 3) in nT to a block of the signal (n, 3), body (sensor) frame.

        `memory` is empty at the start of a run and handed on from block to block: filter states, last samples,
        sub-streams of rng. The contribution does not depend on how a run is cut into blocks.
        """

    def is_active(self, time_s: Array) -> NDArray[np.bool_]:
        """Whether t_0 <= t < t_1 at times (n,) of the run, for `active_s` = (t_0, t_1)."""
        low, high = self.active_s or (-np.inf, np.inf)
        return np.asarray((time_s >= low) & (time_s < high))

    def contribution(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution of `apply` while active, else zero; memory and random numbers advance in any case."""
        label = self.apply(state, signal_nT, rng, memory)
        return label if self.active_s is None else np.where(self.is_active(state.time_s)[:, None], label, 0.0)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Columns (n, 3, k) of a change of reference: a different reference temperature, slope or zero.

        A change of the fitted iron along these columns is a matter of convention and no second finding.
        """
        return np.zeros((len(state), 3, 0))

    @classmethod
    def central_reference(cls, state: State) -> dict[str, float]:
        """Reference values in the middle of a recording, such as the mean temperature, by parameter."""
        return {}

    def problem(self) -> str | None:
        """Contradiction between the parameters, None if there is none; single values are checked before."""
        return None

    @property
    def required_inputs(self) -> tuple[str, ...]:
        """Inputs of the motion and channels needed: those of the class, and the channel named by a parameter."""
        name = self.with_role("channel")
        named = getattr(self, name) if name else ""
        return (*self.needs, named) if named else self.needs

    @property
    def first_value(self) -> Any:
        """Value of the first parameter: for most effects its size."""
        return getattr(self, self._parameters[0].name)

    @classmethod
    def describe_parameters(cls) -> None:
        """Collect the annotations of the parameters; called once, when the class is made."""
        own = {name: info for name, info in cls.__pydantic_fields__.items() if name != ACTIVE_WINDOW.name}
        known = tuple(Parameter.of(name, info) for name, info in own.items())
        cls._parameters = known
        cls._spans = {p.name: _span(p) for p in known if p.role == "linear"}
        cls.linear = tuple(cls._spans)
        cls.search = {p.name: p.quantity.tried for p in known if p.role == "listed" and not p.form}
        cls.forms = {p.form: tuple(other for other in known if other.form == p.form) for p in known if p.form}
        cls.tangents = {p.name: _small(p) for p in known if p.role == "tangent"}

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """The parameters with unit, range, shape, default, meaning and role, in the order of the class."""
        return cls._parameters

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the parameters, and of the active window."""
        return (*(p.name for p in cls._parameters), ACTIVE_WINDOW.name)

    @classmethod
    def with_role(cls, *roles: Role) -> str | None:
        """Name of the first parameter with one of the roles, None without."""
        return next((p.name for p in cls._parameters if p.role in roles), None)

    @classmethod
    def search_role(cls) -> Role | None:
        """Role of the parameter that needs a search of the whole recording (moment, place, frequency), None without."""
        return next((p.role for p in cls._parameters if p.role in SEARCHED_ROLES), None)

    @classmethod
    def linear_units(cls, forms: Collection[str] | None = None) -> list[tuple[str, Array]]:
        """The k unit values (parameter, value) that span the linear parameters, one for each column of `basis`.

        forms : only parameters of these fuller forms; PLAIN is the form of every effect.
        """
        return [
            (p.name, unit.reshape(p.shape))
            for p in cls._parameters
            if p.name in cls._spans and (forms is None or p.form in forms)
            for unit in cls._spans[p.name].T
        ]

    @classmethod
    def basis(cls, state: State, signal_nT: Array, forms: Collection[str] | None = None, **nonlinear: Any) -> Array:
        """Columns (n, 3, k): contribution of each unit of the linear parameters, the rest given.

        ``apply == basis @ coefficients``; k = 0 when no parameter is linear. forms : as for `linear_units`.
        """
        high = {p.name: min(1.0, p.high) for p in cls._parameters}
        rng = np.random.default_rng(0)
        units = cls.linear_units(forms)
        columns = np.empty((len(state), 3, len(units)))
        for k, (name, unit) in enumerate(units):
            values: dict[str, Any] = {name: unit * high[name], **nonlinear}
            effect = cls(**values)
            np.divide(effect.contribution(state, signal_nT, rng, {}), high[name], out=columns[:, :, k])
        return columns

    def coefficients(self, forms: Collection[str] | None = None) -> Array:
        """The linear parameters as (k,) factors of the columns of `basis`; forms : as for `linear_units`."""
        parts = [
            np.linalg.lstsq(self._spans[p.name], np.ravel(getattr(self, p.name)), rcond=None)[0]
            for p in self._parameters
            if p.name in self._spans and (forms is None or p.form in forms)
        ]
        return np.concatenate([np.zeros(0), *parts])

    @property
    def forms_in_use(self) -> tuple[str, ...]:
        """PLAIN, and the fuller forms with a parameter that differs from the default."""
        used = (
            form for form, several in self.forms.items() if any(getattr(self, p.name) != p.default for p in several)
        )
        return (PLAIN, *used)

    @classmethod
    def combine(
        cls, coefficients: Sequence[float] | Array, forms: Collection[str] | None = None, **nonlinear: Any
    ) -> Self:
        """The effect whose linear parameters have the given (k,) coefficients; the inverse of `coefficients`.

        forms : as for `linear_units`; parameters of further forms keep their defaults.
        """
        values: dict[str, Any] = {}
        for (name, unit), factor in zip(cls.linear_units(forms), np.asarray(coefficients), strict=True):
            values[name] = values.get(name, 0.0) + factor * unit
        return cls(**values, **nonlinear)


class Replacement(Effect):
    """An effect whose output replaces the signal: a delayed, clipped, rounded or repeated value.

    A subclass writes `replace`, and the contribution is the difference. The chain takes the output as the signal, so
    rounded values lie on the grid of the converter, and repeated values are equal to the last bit.
    """

    @abstractmethod
    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Output signal (n, 3) of the effect."""

    def replaced(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Output signal (n, 3): `replace` while the effect is active, else the input."""
        out = self.replace(state, signal_nT, rng, memory)
        return out if self.active_s is None else np.where(self.is_active(state.time_s)[:, None], out, signal_nT)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution (n, 3): output signal minus input signal."""
        return self.replace(state, signal_nT, rng, memory) - signal_nT


def _span(parameter: Parameter) -> Array:
    """Columns (size, k): the unit values of a linear parameter, flat."""
    if not parameter.quantity.units:
        return np.eye(int(np.prod(parameter.shape)))
    return np.array([np.ravel(unit) for unit in parameter.quantity.units], dtype=np.float64).T


def _small(parameter: Parameter) -> tuple[Vec3, ...]:
    """A small value of a tangent parameter along each component."""
    return tuple((float(x), float(y), float(z)) for x, y, z in SMALL * np.eye(parameter.shape[0]))
