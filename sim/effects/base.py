"""An effect: one frozen class of parameters that the simulator injects, the dataset labels and a diagnosis proposes."""

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
"""The form that an effect always has, see `Quantity.form`."""
SMALL = 0.01
"""Of a tangent parameter, in its unit: small enough that contributions add up."""


def array(values: Vec3 | Mat3 | float | tuple[float, ...]) -> Array:
    """A parameter's value as an array."""
    return np.array(values, dtype=np.float64)


@dataclass_transform(frozen_default=True)
def frozen(cls: type[E]) -> type[E]:
    """Make an effect of a class: its annotated parameters become the checked fields of a frozen dataclass.

    Values are checked when an effect is made and kept as floats in tuples; InputError names the wrong one.
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
    """One disturbance: a class decorated with `frozen`, of physical parameters with their unit in the name.

    ``signal_out = signal_in + apply(state, signal_in, rng, memory)``: what it returns is also its label. With
    `active_s` that holds from one time of the run until another, and outside the effect contributes nothing.

    A parameter is a field annotated with a `Quantity` (unit, range, meaning, role), a `Choice` (a word) or a
    `ChannelName`, and has a default; with all defaults the effect does nothing. The roles say what a fit may do, see
    `values.Role`.

    A subclass also says: `name`; `stage`, where in the chain it acts; `needs`, what must be known of the motion
    ("attitude", "rate", "position") and the channels that it depends on, by column; `example`, values with which it
    acts; `traits`, how it shows and is told from others; `stochastic`, whether it draws from rng; `static`, whether
    field, channels and time at one instant decide it, so that a calibration of the instrument can take it out;
    `continuous`, whether the field's course between samples decides it, so that the simulator gives it every step.
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
    """Names of the parameters in which the contribution is linear; they give `basis` for free."""
    search: ClassVar[dict[str, tuple[float, ...]]]
    """The values to try of each listed parameter."""
    forms: ClassVar[dict[str, tuple[Parameter, ...]]]
    """The parameters of each fuller form, in the order of the class."""
    tangents: ClassVar[dict[str, tuple[Vec3, ...]]]
    """Small values of each tangent parameter, one along each component."""

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
        sub-streams of rng. Cutting a run into other blocks gives the same contribution.
        """

    def is_active(self, time_s: Array) -> NDArray[np.bool_]:
        """Whether it acts at times (n,) of the run."""
        low, high = self.active_s or (-np.inf, np.inf)
        return np.asarray((time_s >= low) & (time_s < high))

    def contribution(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """What `apply` gives while the effect acts, else zero; its memory and its random numbers know no switch."""
        label = self.apply(state, signal_nT, rng, memory)
        return label if self.active_s is None else np.where(self.is_active(state.time_s)[:, None], label, 0.0)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Columns (n, 3, k) by which it would differ if it were counted from elsewhere: another temperature, slope.

        A change of the iron along these is no finding of its own beside the effect.
        """
        return np.zeros((len(state), 3, 0))

    @classmethod
    def central_reference(cls, state: State) -> dict[str, float]:
        """Fixed parameters from which a curve is best counted along a course: a temperature of its middle."""
        return {}

    def problem(self) -> str | None:
        """What is wrong with the parameters taken together, if anything; each alone is checked before."""
        return None

    @property
    def required_inputs(self) -> tuple[str, ...]:
        """What must be known for it: what its class needs, and the channel that it names."""
        name = self.with_role("channel")
        named = getattr(self, name) if name else ""
        return (*self.needs, named) if named else self.needs

    @classmethod
    def describe_parameters(cls) -> None:
        """Keep what the annotations say of the parameters; once, when the class is made."""
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
        """Names of the parameters, and of the window."""
        return (*(p.name for p in cls._parameters), ACTIVE_WINDOW.name)

    @classmethod
    def with_role(cls, *roles: Role) -> str | None:
        """Name of the first parameter that has one of these roles."""
        return next((p.name for p in cls._parameters if p.role in roles), None)

    @classmethod
    def search_role(cls) -> Role | None:
        """What of it no list of values can hold, so that a search must find it: a moment, a place, a frequency."""
        return next((p.role for p in cls._parameters if p.role in SEARCHED_ROLES), None)

    @classmethod
    def linear_units(cls, forms: Collection[str] | None = None) -> list[tuple[str, Array]]:
        """The k unit values (parameter, value) that span the linear parameters: one of each column of `basis`.

        forms : only parameters of these fuller forms; PLAIN is what the effect always has.
        """
        return [
            (p.name, unit.reshape(p.shape))
            for p in cls._parameters
            if p.name in cls._spans and (forms is None or p.form in forms)
            for unit in cls._spans[p.name].T
        ]

    @classmethod
    def basis(cls, state: State, signal_nT: Array, forms: Collection[str] | None = None, **nonlinear: Any) -> Array:
        """Columns (n, 3, k): the contribution of each unit of the linear parameters, for given other parameters.

        ``apply == basis @ coefficients``; k = 0 when no parameter is linear. forms : as for `linear_units`.
        """
        high = {p.name: min(1.0, p.high) for p in cls._parameters}
        rng = np.random.default_rng(0)
        units = cls.linear_units(forms)
        columns = np.zeros((len(state), 3, len(units)))
        for k, (name, unit) in enumerate(units):
            values: dict[str, Any] = {name: unit * high[name], **nonlinear}
            effect = cls(**values)
            columns[:, :, k] = effect.contribution(state, signal_nT, rng, {}) / high[name]
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
        """PLAIN, and the fuller forms of which a parameter is another than where it does nothing."""
        used = (
            form for form, several in self.forms.items() if any(getattr(self, p.name) != p.default for p in several)
        )
        return (PLAIN, *used)

    @classmethod
    def combine(
        cls, coefficients: Sequence[float] | Array, forms: Collection[str] | None = None, **nonlinear: Any
    ) -> Self:
        """The effect whose linear parameters have the given (k,) coefficients; the inverse of `coefficients`.

        forms : as for `linear_units`; what is of another form is not there.
        """
        values: dict[str, Any] = {}
        for (name, unit), factor in zip(cls.linear_units(forms), np.asarray(coefficients), strict=True):
            values[name] = values.get(name, 0.0) + factor * unit
        return cls(**values, **nonlinear)


class Replacement(Effect):
    """An effect that puts another value in the signal's place: a delayed, clipped, rounded or repeated one.

    A subclass writes `replace`; the contribution follows. The chain takes the value itself, so that rounded values
    lie on their lattice and repeated ones are equal to the last bit.
    """

    @abstractmethod
    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """The signal (n, 3) that leaves the effect."""

    def replaced(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """The signal (n, 3) that leaves: what `replace` gives while the effect acts, else what came."""
        out = self.replace(state, signal_nT, rng, memory)
        return out if self.active_s is None else np.where(self.is_active(state.time_s)[:, None], out, signal_nT)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution (n, 3): the signal that leaves minus the signal that came."""
        return self.replace(state, signal_nT, rng, memory) - signal_nT


def _span(parameter: Parameter) -> Array:
    """Columns (size, k): the unit values of a linear parameter, flat."""
    if not parameter.quantity.units:
        return np.eye(int(np.prod(parameter.shape)))
    return np.array([np.ravel(unit) for unit in parameter.quantity.units], dtype=np.float64).T


def _small(parameter: Parameter) -> tuple[Vec3, ...]:
    """A small value of a tangent parameter along each component."""
    return tuple((float(x), float(y), float(z)) for x, y, z in SMALL * np.eye(parameter.shape[0]))
