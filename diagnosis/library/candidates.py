"""Candidates: every effect with recorded inputs, as columns of the linear problem."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.numerics.rates import body_rate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import PLAIN, Effect
from sim.effects.parameters import ACTIVE_WINDOW, Window
from sim.state import State
from validation.signals.neighbours import as_iron_sees

HEADROOM = 10.0
"""Ratio of the bound of a wave's amplitude to the largest amplitude kept without shortening the wave."""


@dataclass(frozen=True)
class Candidate:
    """An effect at given nonlinear parameters: ``E c``, columns E (n, q, k) and coefficients c (k,) left to fit.

    `tried`: number of settings that a search compared, for the price of the search. `forms`: fuller forms of the effect
    whose columns are included. `span`: unit vectors (s, 3) east, north, up of a field of which no more is seen.
    """

    effect: type[Effect]
    nonlinear: tuple[tuple[str, Any], ...] = ()
    tried: int = 1
    forms: tuple[str, ...] = ()
    span: tuple[tuple[float, ...], ...] = ()

    @classmethod
    def of(cls, effect: Effect) -> Candidate:
        """The candidate of an effect: linear coefficients are free, all other parameters fixed."""
        free = {*effect.linear, *effect.tangents, effect.with_role("phase")}
        rest = tuple((p.name, getattr(effect, p.name)) for p in effect.parameters() if p.name not in free)
        window = () if effect.active_s is None else ((ACTIVE_WINDOW.name, effect.active_s),)
        return cls(type(effect), (*rest, *window), forms=effect.forms_in_use[1:])

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def phase(self) -> str | None:
        """Name of the phase parameter, if any: a sine and a cosine then span the phase."""
        return self.effect.with_role("phase")

    @property
    def one_run(self) -> bool:
        """Whether the effect is an event of one run, at a moment or in a window, absent from other recordings."""
        return self.effect.traits.one_run or self.window is not None

    @property
    def window(self) -> Window:
        """Time interval in which the effect acts, where shorter than the run."""
        window: Window = dict(self.nonlinear).get(ACTIVE_WINDOW.name)
        return window

    @property
    def can_have_window(self) -> bool:
        """Whether the effect can begin and end: no natural field, no course of the whole run."""
        return self.effect.stage != "field" and not self.effect.traits.whole_run

    def at(self, values: dict[str, Any], tried: int = 0) -> Candidate:
        """The candidate at new nonlinear parameters; `tried`: number of settings compared, 0: unchanged."""
        return replace(self, nonlinear=tuple((dict(self.nonlinear) | values).items()), tried=tried or self.tried)

    def scaled(self, by: float) -> list[Candidate]:
        """The candidate with its listed number times and over a factor, where within bounds."""
        listed = [p for p in self.effect.parameters() if p.name in self.effect.search]
        moved = [(p, dict(self.nonlinear)[p.name] * f) for p in listed for f in (by, 1 / by)]
        return [self.at({p.name: value}) for p, value in moved if p.low <= value <= p.high]

    def columns(self, problem: LinearProblem) -> Array:
        """Columns E (n, q, k) of the problem."""
        return problem.whitened(self.contribution_nT(problem), self.effect)

    def contribution_nT(self, problem: LinearProblem) -> Array:
        """Contribution (n, 3, k) in nT of each column, at the effect's place in the chain.

        Input signal: the field, or for sensor and electronics the prediction of the base. Effects with memory use the
        prediction integrated from the body rate, free of attitude noise, and start anew after a pause. Other effects of
        the continuous course use the prediction from neighbouring samples.
        """
        state = problem.state
        if self.effect.traits.correlates_noise:
            sections = [(select_samples(state, each), problem.integrated_nT[each]) for each in problem.sections]
            return np.concatenate([self._contribution(*section) for section in sections])
        if not (self.effect.continuous and problem.mode == "vector"):
            return self._contribution(state, problem.input_nT(self.effect))
        iron_nT, read_nT = problem.clean_nT - problem.beyond_nT, problem.neighbour_nT
        return as_iron_sees(self._contribution(state, read_nT), read_nT, iron_nT)

    def _contribution(self, state: State, signal: Array) -> Array:
        """Columns (n, 3, k): of the linear parameters, at two phases a quarter period apart, or of small tangents."""
        given, phases = dict(self.nonlinear), [{self.phase: 0.0}, {self.phase: 90.0}] if self.phase else [{}]
        if self.effect.linear:
            plain = [self.seen(self.effect.basis(state, signal, (PLAIN,), **given | phase)) for phase in phases]
            fuller = [self.effect.basis(state, signal, self.forms, **given | phases[0])] if self.forms else []
            return _side_by_side(plain + fuller)
        small = [{name: value} for name, values in self.effect.tangents.items() for value in values] or [{}]
        effects, rng = (self.effect(**given | values) for values in small), np.random.default_rng(0)
        return np.stack([effect.contribution(state, signal, rng, {}) for effect in effects], axis=2)

    def seen(self, axes: Array) -> Array:
        """Columns (n, 3, s) along the span, of columns (n, 3, 3) along east, north and up; unchanged without a span."""
        return axes @ np.array(self.span).T if self.span else axes

    @property
    def bounds(self) -> Array:
        """Lower and upper bound (., 2) of each linear parameter."""
        of = {p.name: (p.low, p.high) for p in self.effect.parameters()}
        tangents = [name for name, small in self.effect.tangents.items() for _ in small]
        names = tangents or [name for name, _ in self.effect.linear_units((PLAIN, *self.forms))]
        return np.array([of[name] for name in names]).reshape(-1, 2)

    def to_effect(self, c: Array) -> Effect:
        """The effect with fitted coefficients (k,), clipped to its bounds."""
        values, rest = self._parameters(c)
        within = np.clip(values, *self.bounds.T)
        if not self.effect.tangents:
            return self.effect.combine(within, (PLAIN, *self.forms), **rest)
        (name,) = self.effect.tangents
        return self.effect(**rest, **{name: tuple(within)})

    def within_bounds(self, c: Array) -> bool:
        """Whether coefficients (k,) are within bounds, or positive for an effect without linear parameters."""
        values, (low, high) = self._parameters(c)[0], self.bounds.T
        return bool(((low <= values) & (values <= high)).all() if len(values) else c[0] > 0)

    def _parameters(self, c: Array) -> tuple[Array, dict[str, Any]]:
        """Values of the linear parameters at coefficients (k,) of the columns, and all other parameters by name."""
        given = dict(self.nonlinear)
        if self.effect.tangents:
            (small,) = self.effect.tangents.values()
            return c @ np.array(small), given
        if not self.effect.linear:
            return np.zeros(0), given
        if self.span:
            c = (c.reshape(-1, len(self.span)) @ np.array(self.span)).ravel()
        if not self.phase:
            return c, given
        k = len(self.effect.linear_units((PLAIN,)))
        amplitude, wave = self._wave(c[: 2 * k].reshape(2, k), self.bounds[:k, 1] / HEADROOM)
        return np.concatenate([amplitude, c[2 * k :]]), given | wave

    def _wave(self, parts: Array, most: Array) -> tuple[Array, dict[str, float]]:
        """Amplitude (k,) of a sine and a cosine (2, k), with phase and period by name.

        A short section of a long wave equals a section of a shorter, lower wave of the same slope and curvature: a bend
        then needs no amplitude at the bounds.
        """
        phase, period = str(self.phase), self.effect.with_role("period")
        amplitude, phase_deg = amplitude_and_phase(parts)
        if not period or not (np.abs(amplitude) > most).any():
            return amplitude, {phase: phase_deg}
        sine, cosine = (np.abs(parts) / most).max(axis=1)
        faster = max(1.0, float(sine), math.sqrt(cosine))
        amplitude, phase_deg = amplitude_and_phase(parts / np.array([[faster], [faster**2]]))
        long_s = dict(self.nonlinear).get(period, getattr(self.effect(), period))
        return amplitude, {phase: phase_deg, period: long_s / faster}

    def is_natural(self, problem: LinearProblem, c: Array) -> bool:
        """Whether the contribution changes, on average, no faster in the Earth's frame than nature allows."""
        fastest_nT_s = self.effect.traits.max_rate_nT_s
        if fastest_nT_s is None:
            return True
        state = problem.state
        course_nT = np.einsum("nij,nj->ni", state.R_wb, self.contribution_nT(problem) @ c)
        passed_s = float(state.time_s[-1] - state.time_s[0])
        return float(np.linalg.norm(np.ptp(course_nT, axis=0))) < fastest_nT_s * passed_s


def _side_by_side(parts: list[Array]) -> Array:
    """Columns (n, 3, k) of several groups; no copy of a single group, which is large for a long recording."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)


def select_samples(state: State, samples: slice) -> State:
    """A slice of the samples of a state."""
    by_sample = ("time_s", "pos_enu_m", "R_wb", "rate_rad_s", "field_nT", "field_rate_nT_s")
    cut: dict[str, Any] = {name: getattr(state, name)[samples] for name in by_sample}
    return replace(state, **cut, channels={name: value[samples] for name, value in state.channels.items()})


def amplitude_and_phase(parts: Array) -> tuple[Array, float]:
    """Amplitude (k,) and phase in degrees of coefficients (2, k) of sine and cosine, with a single phase.

    The best ``[a cos p, a sin p]`` is the first singular pair of the coefficients, with p from -90 to 90 degrees.
    """
    u, s, v = np.linalg.svd(parts.T, full_matrices=False)
    sign = -1.0 if v[0, 0] < 0 else 1.0
    return sign * u[:, 0] * s[0], float(np.degrees(np.arctan2(sign * v[0, 1], sign * v[0, 0])))


def propose_candidates(problem: LinearProblem, without: frozenset[str] = frozenset()) -> dict[str, list[Candidate]]:
    """Candidates of every effect with recorded inputs, at the values that the effect's class lists.

    Every combination of listed values, for all motors together and for each. without : names of effects left out.
    """
    proposed: dict[str, list[Candidate]] = {}
    for effect in EFFECTS:
        if effect.name in without or not _is_proposed(effect, problem):
            continue
        grid: dict[str, tuple[Any, ...]] = {name: _above_noise(effect, name, problem) for name in effect.search}
        if motor := effect.with_role("motor"):
            motors = problem.state.motors
            grid[motor] = (0, *motors) if len(motors) > 1 else (0,)
        several, span = itertools.product(*grid.values()), _span(effect, problem)
        proposed[effect.name] = [Candidate(effect, tuple(zip(grid, each, strict=True)), span=span) for each in several]
    return proposed


def iron_candidates() -> dict[str, list[Candidate]]:
    """Candidates of the effects that the base absorbs completely; changes of iron are read from the base itself."""
    return {effect.name: [Candidate(effect)] for effect in EFFECTS if effect.traits.absorbed}


def attitude_turns(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of small constant turns of the attitude."""
    turns = [Candidate(effect).columns(problem) for effect in EFFECTS if effect.traits.attitude_error]
    return np.concatenate(turns, axis=2)


def _span(effect: type[Effect], problem: LinearProblem) -> tuple[tuple[float, ...], ...]:
    """Directions of a field that strength, or strength and dip, show; empty where all are, or for another effect."""
    if problem.mode != "strength" or effect.stage != "field":
        return ()
    field = problem.state.field_enu_nT
    shown = [field] if problem.level is None else [field * [1, 1, 0], np.array([0.0, 0.0, 1.0])]
    return tuple(tuple((direction / np.linalg.norm(direction)).tolist()) for direction in shown)


def _is_proposed(effect: type[Effect], problem: LinearProblem) -> bool:
    """Whether an effect has columns beside the base, named causes, recorded inputs, and a path long enough."""
    elsewhere = effect.traits.absorbed or effect.stochastic or effect.with_role("channel")
    columns = effect.linear or effect.search or effect.tangents
    if elsewhere or not columns or problem.missing_inputs(effect):
        return False
    still = "position" in effect.needs and np.ptp(problem.state.pos_enu_m, axis=0).max() < problem.policy.least_path_m
    return not still


def _above_noise(effect: type[Effect], name: str, problem: LinearProblem) -> tuple[Any, ...]:
    """Listed values of a parameter, without values that would fit the noise.

    Without attitude the course is itself a measurement. A loop narrower than the noise would follow the noise to which
    it is fitted. So would a lag of the field's rate derived from the measurement: a slope excludes the current sample,
    a lagged slope does not.
    """
    listed, unit = effect.search[name], next(p.unit for p in effect.parameters() if p.name == name)
    if problem.mode == "strength" and unit == "s" and "rate" in effect.needs and body_rate(problem.recording) is None:
        return listed[:1]
    if problem.mode != "strength" or unit != "nT":
        return listed
    least = problem.policy.least_loop * float(problem.sigma_nT.max())
    return tuple(value for value in listed if np.min(value) >= least) or listed[-1:]
