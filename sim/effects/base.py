"""An effect: one frozen dataclass that the simulator injects, the dataset labels and the diagnosis proposes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np

from scenarios.errors import InputError
from sim.effects.values import Parameter
from sim.state import Array, State

Vec3 = tuple[float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
ZERO3: Vec3 = (0.0, 0.0, 0.0)
ZERO33: Mat3 = (ZERO3, ZERO3, ZERO3)
Memory = dict[str, Any]


def array(values: Vec3 | Mat3 | float | tuple[float, ...]) -> Array:
    """A parameter's value as an array."""
    return np.array(values, dtype=np.float64)


def parameter(
    default: Any, unit: str, low: float, high: float, doc: str, *, per_axis: bool = False, several: bool = False
) -> Any:
    """A dataclass field with what users and the diagnosis need: unit, the bounds of each component, meaning.

    `per_axis`: one number may stand for all three axes. `several`: a number, or any number of them.
    """
    notes = {"unit": unit, "low": low, "high": high, "doc": doc, "per_axis": per_axis, "several": several}
    return field(default=default, metadata=notes)


def choice(default: str, options: tuple[str, ...], doc: str) -> Any:
    """A dataclass field that takes one of a few words."""
    return field(default=default, metadata={"doc": doc, "options": options})


@dataclass(frozen=True)
class Effect(ABC):
    """One disturbance: a frozen dataclass of physical parameters (unit in the name), each made by `parameter`.

    ``signal_out = signal_in + apply(state, signal_in, rng, memory)``: what it returns is also its label.

    Class attributes: `name` (fixed by DESIGN), `stage` ("field", "vehicle", "sensor", "electronics"), `needs`
    (columns of State that must be measured for the diagnosis to propose it: "attitude", "rate", "position",
    "current", "temperature"), `linear` (the parameters in which the contribution is linear, zero when they are zero:
    they give `basis` for free), `stochastic` (draws from rng), `static` (decided by field, temperature, current and
    time at one instant: what a calibration of the instrument can take out, and the hold-out keeps), `units` (the unit
    values of a linear parameter whose components are not free, such as a symmetric matrix; otherwise each component
    is one), `search` (values of the other parameters that the diagnosis tries, in every combination, before it refines
    the best), `tangents` (small values of a parameter without `linear` whose contributions add up).

    Values are checked and brought to tuples of floats when an effect is made; `InputError` names the wrong one.
    """

    name: ClassVar[str]
    stage: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    linear: ClassVar[tuple[str, ...]] = ()
    stochastic: ClassVar[bool] = False
    static: ClassVar[bool] = False
    units: ClassVar[dict[str, tuple[Any, ...]]] = {}
    search: ClassVar[dict[str, tuple[Any, ...]]] = {}
    tangents: ClassVar[dict[str, tuple[Any, ...]]] = {}

    def __post_init__(self) -> None:
        for p in self.parameters():
            object.__setattr__(self, p.name, p.checked(getattr(self, p.name), f"{self.name}.{p.name}"))
        if problem := self.problem():
            raise InputError(problem, where=self.name)

    @abstractmethod
    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution (n, 3) in nT to a block of the signal (n, 3), body (sensor) frame.

        `memory` is empty at the start of a run and handed on from block to block: filter states, last samples,
        sub-streams of rng. Cutting a run into other blocks gives the same contribution.
        """

    def problem(self) -> str | None:
        """What is wrong with the parameters taken together, if anything; each alone is checked before."""
        return None

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """The parameters with unit, bounds, shape, default and meaning, in the order of the class."""
        return _parameters(cls)

    @classmethod
    def linear_units(cls) -> list[tuple[str, Array]]:
        """The k unit values (parameter, value) that span the linear parameters: one of each column of `basis`."""
        shapes = {p.name: p.shape for p in cls.parameters()}
        return [(name, unit) for name in cls.linear for unit in _units(cls.units.get(name), shapes[name])]

    @classmethod
    def basis(cls, state: State, signal_nT: Array, **nonlinear: Any) -> Array:
        """Columns (n, 3, k): the contribution of each unit of the linear parameters, for given other parameters.

        ``apply == basis @ coefficients``; k = 0 when no parameter is linear.
        """
        high = {p.name: min(1.0, p.high) for p in cls.parameters()}
        rng = np.random.default_rng(0)
        columns = np.zeros((len(state), 3, len(cls.linear_units())))
        for k, (name, unit) in enumerate(cls.linear_units()):
            effect = cls(**{name: unit * high[name]}, **nonlinear)
            columns[:, :, k] = effect.apply(state, signal_nT, rng, {}) / high[name]
        return columns

    def coefficients(self) -> Array:
        """The linear parameters as (k,) factors of the columns of `basis`."""
        parts = [np.zeros(0)]
        for name in self.linear:
            units = np.array([unit.ravel() for other, unit in self.linear_units() if other == name])
            parts.append(np.linalg.lstsq(units.T, np.ravel(getattr(self, name)), rcond=None)[0])
        return np.concatenate(parts)

    @classmethod
    def combine(cls, coefficients: Sequence[float] | Array, **nonlinear: Any) -> Self:
        """The effect whose linear parameters have the given (k,) coefficients; the inverse of `coefficients`."""
        values: dict[str, Array] = {}
        for factor, (name, unit) in zip(coefficients, cls.linear_units(), strict=True):
            values[name] = values.get(name, 0.0) + factor * unit
        return cls(**values, **nonlinear)


@dataclass(frozen=True)
class Replacement(Effect):
    """An effect that puts another value in the signal's place: a delayed, clipped, rounded or repeated one.

    A subclass writes `replace`; the contribution follows. The chain takes the value itself, so that rounded values
    lie on their lattice and repeated ones are equal to the last bit.
    """

    @abstractmethod
    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """The signal (n, 3) that leaves the effect."""

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        """Contribution (n, 3): the signal that leaves minus the signal that came."""
        return self.replace(state, signal_nT, rng, memory) - signal_nT


@cache
def _parameters(cls: type[Effect]) -> tuple[Parameter, ...]:
    return tuple(Parameter.of(f.name, f.default, f.metadata) for f in fields(cls))


def _units(given: tuple[Any, ...] | None, shape: tuple[int, ...]) -> list[Array]:
    if given is not None:
        return [np.array(unit, dtype=float) for unit in given]
    size = int(np.prod(shape))
    return list(np.eye(size).reshape(size, *shape))
