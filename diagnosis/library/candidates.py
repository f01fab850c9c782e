"""What may be missing: every effect that the recording has the channels for, as columns of the linear problem."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from calib.numerics.rates import body_rate
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import seen_by
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import PLAIN, Effect
from sim.effects.parameters import ACTIVE_WINDOW, Parameter, Window
from sim.state import State
from validation.signals.neighbours import as_iron_sees

BY_SAMPLE = frozenset({"time_s", "pos_enu_m", "R_wb", "rate_rad_s", "field_nT", "field_rate_nT_s"})
"""What a state holds of every sample, beside its channels."""

HEADROOM = 10.0
"""Times that the bound of a wave's amplitude is above what a longer wave than needed may have."""


@dataclass(frozen=True)
class Candidate:
    """An effect with values of its nonlinear parameters; its columns are linear in what is then left to fit.

    `tried`: how many settings a search compared to find this one, for an honest price of the search. `forms`: the
    fuller forms of the effect whose columns it has too.
    """

    effect: type[Effect]
    nonlinear: tuple[tuple[str, Any], ...] = ()
    tried: int = 1
    forms: tuple[str, ...] = ()

    @classmethod
    def of(cls, effect: Effect) -> Candidate:
        """The effect with its coefficients left to fit again, all else as it is."""
        free = {*effect.linear, *effect.tangents, effect.with_role("phase")}
        rest = tuple((p.name, getattr(effect, p.name)) for p in effect.parameters() if p.name not in free)
        window = () if effect.active_s is None else ((ACTIVE_WINDOW.name, effect.active_s),)
        return cls(type(effect), (*rest, *window), forms=effect.forms_in_use[1:])

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    @property
    def phase(self) -> str | None:
        """The effect's phase, if it has one: a sine and a cosine then span it."""
        return self.effect.with_role("phase")

    @property
    def once(self) -> bool:
        """Whether it is an event of its own run, at a moment or in a window, that no other recording can show."""
        return self.effect.traits.one_run or self.window is not None

    @property
    def window(self) -> Window:
        """From when to when it acts, where that is a part of the run."""
        window: Window = dict(self.nonlinear).get(ACTIVE_WINDOW.name)
        return window

    @property
    def may_be_switched(self) -> bool:
        """Whether it can begin and end: none of nature's, no course of the whole run."""
        return self.effect.stage != "field" and not self.effect.traits.whole_run

    @property
    def settings(self) -> tuple[dict[str, Any], ...]:
        """The values of the nonlinear parameters behind each group of columns: one, or two phases a quarter apart."""
        given = dict(self.nonlinear)
        if self.effect.tangents:
            return tuple({**given, name: value} for name, values in self.effect.tangents.items() for value in values)
        if self.phase:
            return ({**given, self.phase: 0.0}, {**given, self.phase: 90.0})
        return (given,)

    def at(self, values: dict[str, Any], tried: int = 0) -> Candidate:
        """The same effect at other values of some nonlinear parameters, found among so many (0: as many as before)."""
        return replace(self, nonlinear=tuple((dict(self.nonlinear) | values).items()), tried=tried or self.tried)

    def with_form(self, form: str) -> Candidate:
        """The same effect with the columns of a fuller form too."""
        return replace(self, forms=(*self.forms, form))

    def scaled(self, by: float) -> list[Candidate]:
        """The same effect with its listed number times and over a factor, where it takes such a number."""
        moved = [(p, dict(self.nonlinear)[p.name] * f) for p in self._listed for f in (by, 1 / by)]
        return [self.at({p.name: value}) for p, value in moved if p.low <= value <= p.high]

    @property
    def _listed(self) -> list[Parameter]:
        return [p for p in self.effect.parameters() if p.name in self.effect.search]

    def columns(self, problem: LinearProblem) -> Array:
        """Columns E (n, q, k) of the problem."""
        return problem.whitened(self.contribution_nT(problem), self.effect)

    def contribution_nT(self, problem: LinearProblem) -> Array:
        """Columns (n, 3, k) in nT at the effect's place in the chain.

        The signal that the effect meets there is the field, or for the sensor and its electronics what the base
        predicts; what remembers meets its course by the body's rate, in which an attitude's noise is no motion, and
        begins anew after a pause. What follows the course in other ways meets it by neighbouring samples.
        """
        state = problem.state
        if self.effect.traits.correlates_noise:
            parts = (self._contribution(part(state, one), problem.course_nT[one]) for one in problem.stretches)
            return np.concatenate(list(parts))
        if not (self.effect.continuous and problem.mode == "vector"):
            return self._contribution(state, problem.met_nT(self.effect))
        return as_iron_sees(self._contribution(state, problem.beside_nT), problem.beside_nT, problem.clean_nT)

    def _contribution(self, state: State, signal: Array) -> Array:
        if self.effect.linear:
            plain = [self.effect.basis(state, signal, (PLAIN,), **one) for one in self.settings]
            fuller = [self.effect.basis(state, signal, self.forms, **self.settings[0])] if self.forms else []
            return np.concatenate([*plain, *fuller], axis=2)
        rng = np.random.default_rng(0)
        return np.stack([self.effect(**one).contribution(state, signal, rng, {}) for one in self.settings], axis=2)

    def made(self, c: Array) -> Effect:
        """The effect with fitted coefficients (k,) of its columns, brought into its bounds."""
        given = dict(self.nonlinear)
        if self.effect.tangents:
            name, values, (low, high) = self._turned(c)
            return self.effect(**given, **{name: tuple(np.clip(values, low, high))})
        if not self.effect.linear:
            return self.effect(**given)
        values, wave = self._without_phase(c)
        low, high = np.array(self.bounds).T
        return self.effect.combine(np.clip(values, low, high), (PLAIN, *self.forms), **{**given, **wave})

    def _turned(self, c: Array) -> tuple[str, Array, tuple[float, float]]:
        """The parameter of small turns by name, its values at coefficients (k,), and their bounds."""
        ((name, small),) = self.effect.tangents.items()
        bounds = next((p.low, p.high) for p in self.effect.parameters() if p.name == name)
        return name, c @ np.array(small), bounds

    def _without_phase(self, c: Array) -> tuple[Array, dict[str, float]]:
        """The linear parameters' coefficients, and the wave's phase by name, of coefficients (k,) of the columns.

        A short stretch of a long wave is one of a shorter wave that is less high: a bend needs no height at the bounds.
        """
        if not self.phase:
            return c, {}
        k = len(self.effect.linear_units((PLAIN,)))
        amplitude, phase_deg = amplitude_and_phase(c[: 2 * k])
        wave = {self.phase: phase_deg}
        most, period = np.array(self.bounds[:k])[:, 1] / HEADROOM, self.effect.with_role("period")
        if period and (np.abs(amplitude) > most).any():
            amplitude, wave = self._shorter(c[: 2 * k].reshape(2, k), most, self.phase, period)
        return np.concatenate([amplitude, c[2 * k :]]), wave

    def _shorter(self, waves: Array, most: Array, phase: str, period: str) -> tuple[Array, dict[str, float]]:
        """Amplitude (k,), and phase and period by name, of a shorter wave with the slope and the bend of two (2, k)."""
        sine, cosine = (np.abs(waves) / most).max(axis=1)
        faster = max(1.0, float(sine), math.sqrt(cosine))
        amplitude, phase_deg = amplitude_and_phase((waves / np.array([[faster], [faster**2]])).ravel())
        long_s = dict(self.nonlinear).get(period, getattr(self.effect(), period))
        return amplitude, {phase: phase_deg, period: long_s / faster}

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Least and greatest value of each linear coefficient without a phase."""
        of = {p.name: (p.low, p.high) for p in self.effect.parameters()}
        return [of[name] for name, _ in self.effect.linear_units((PLAIN, *self.forms))]

    def possible(self, c: Array) -> bool:
        """Whether the effect can have coefficients (k,): none beyond its bounds, none of one sign with the other."""
        if self.effect.linear:
            values = self._without_phase(c)[0]
            return all(low <= v <= high for v, (low, high) in zip(values, self.bounds, strict=True))
        if self.effect.tangents:
            _, values, (low, high) = self._turned(c)
            return bool(((low <= values) & (values <= high)).all())
        return bool(c[0] > 0)

    def is_natural(self, problem: LinearProblem, c: Array) -> bool:
        """Whether with coefficients (k,) it changes in the earth's frame no faster than nature does, in the mean."""
        fastest_nT_s = self.effect.traits.max_rate_nT_s
        if fastest_nT_s is None:
            return True
        state = problem.state
        course_nT = np.einsum("nij,nj->ni", state.R_wb, self.contribution_nT(problem) @ c)
        passed_s = float(state.time_s[-1] - state.time_s[0])
        return float(np.linalg.norm(np.ptp(course_nT, axis=0))) < fastest_nT_s * passed_s


def part(state: State, samples: slice) -> State:
    """Some samples of a state."""
    cut = {f.name: getattr(state, f.name) for f in fields(state)}
    cut |= {name: value[samples] for name, value in cut.items() if name in BY_SAMPLE}
    return State(**cut | {"channels": {name: value[samples] for name, value in state.channels.items()}})


def amplitude_and_phase(c: Array) -> tuple[Array, float]:
    """Amplitude (k/2,) and phase in degrees of coefficients (k,) of sine and cosine: one phase for all, least squares.

    The best ``c = [a cos p, a sin p]`` is the first singular pair of the coefficients as a matrix (k/2, 2); of the two
    that are the same that with p from -90 to 90 degrees.
    """
    u, s, v = np.linalg.svd(c.reshape(2, -1).T, full_matrices=False)
    sign = -1.0 if v[0, 0] < 0 else 1.0
    return sign * u[:, 0] * s[0], float(np.degrees(np.arctan2(sign * v[0, 1], sign * v[0, 0])))


def proposed(problem: LinearProblem, without: frozenset[str] = frozenset()) -> dict[str, list[Candidate]]:
    """Every effect that the recording has the channels for, at the values that its class says to try.

    without : names of effects left out.
    """
    return {
        effect.name: [Candidate(effect, tuple(values.items())) for values in _settings(effect, problem)]
        for effect in EFFECTS
        if effect.name not in without and _is_linear(effect) and _is_measured(effect, problem)
    }


def changes_of_iron() -> dict[str, list[Candidate]]:
    """The effects that the base takes up whole: a change of these is read from the base itself."""
    return {effect.name: [Candidate(effect)] for effect in EFFECTS if effect.traits.absorbed}


def missing_channels(effect: type[Effect], problem: LinearProblem) -> tuple[str, ...]:
    """What an effect needs that the problem does not hold."""
    return tuple(sorted(set(effect.needs) - seen_by(problem)))


def _is_linear(effect: type[Effect]) -> bool:
    """Whether an effect becomes columns beside the base, and says its own causes."""
    if effect.traits.absorbed or effect.stochastic or effect.with_role("channel"):
        return False
    return bool(effect.linear or effect.search or effect.tangents)


def _is_measured(effect: type[Effect], problem: LinearProblem) -> bool:
    """Whether the recording holds the effect's causes; a path may be too short for a field of places."""
    if missing_channels(effect, problem):
        return False
    extent_m = np.ptp(problem.state.pos_enu_m, axis=0).max()
    return "position" not in effect.needs or bool(extent_m >= problem.policy.least_path_m)


def _above_noise(effect: type[Effect], name: str, problem: LinearProblem) -> tuple[Any, ...]:
    """The listed values of a parameter; of a size in nT those above the noise, where the course is a measurement.

    Without attitude a loop as narrow as the noise would follow the very noise that it is fitted to. So would a lag of
    the field's rate that is the measurement's own: a slope holds nothing of the sample at which it is taken, a slope
    that comes late does.
    """
    listed = effect.search[name]
    unit = next(p.unit for p in effect.parameters() if p.name == name)
    if problem.mode != "strength":
        return listed
    if unit == "s" and "rate" in effect.needs and body_rate(problem.recording) is None:
        return listed[:1]
    if unit != "nT":
        return listed
    least = problem.policy.least_loop * float(problem.sigma_nT.max())
    return tuple(value for value in listed if np.min(value) >= least) or listed[-1:]


def _settings(effect: type[Effect], problem: LinearProblem) -> Iterator[dict[str, Any]]:
    grid: dict[str, tuple[Any, ...]] = {name: _above_noise(effect, name, problem) for name in effect.search}
    motor = effect.with_role("motor")
    if motor:
        motors = problem.state.motors
        grid[motor] = (0, *motors) if len(motors) > 1 else (0,)
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))
