"""A recording compared with the model along the recorded motion, as one linear problem."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from diagnosis.problem.known import Known
from diagnosis.problem.motion import pauses_after
from recordings import Recording
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import chain_position, insert_effects, iron_matrix
from sim.effects.kernels import kernel
from sim.state import State
from validation.signals.neighbours import by_neighbours

Mode = Literal["vector", "strength"]
FOLLOWS_CHANNEL = next(effect for effect in EFFECTS if effect.with_role("channel"))
"""The effect that follows any channel."""
SOFT, HARD = sorted(
    (effect for effect in EFFECTS if effect.traits.absorbed and effect.stage == "vehicle"),
    key=lambda effect: effect.traits.constant,
)
"""Iron of the vehicle: a matrix, and a constant."""
STEPS, SETTLED = 4, 0.01
"""Steps at most between the fitted iron and the model's effects behind it, each of which squares the error of the
preceding step, and change in units of the noise that ends them.
"""
IN_EARTH_FRAME = frozenset({"attitude", "position"})
"""Inputs of effects that are not observable in the strength alone, nor between two magnetometers: common to both."""


@dataclass(frozen=True, kw_only=True)
class LinearProblem(Known):
    """A recording and a model as ``y = B beta + E c + noise``, with q outputs for each sample.

    mode "vector": q = 3, y the measured axes less a first fit of B = [predicted field, 1] on each axis: hard and soft
    iron, including a fixed rotation of the sensor. mode "strength": q = 1, y = |h| - F of the calibrated field h, B the
    nine changes of offset and symmetric matrix; with a `level` q = 2, the second output being the dip as an angle times
    F. `output_axes` (n, q, 3): directions of the outputs in strength mode. y (n, q) is divided by the noise of a
    sample, `sigma_nT` (q,). `base` B: (n, p) with coefficients for each output, or (n, q, p) over the noise with shared
    coefficients. `usable` (n,): 0 for invalid samples (repeated, clipped, spikes), else 1. `turn` (3, 3): from the
    undisturbed to the measured field; `clean_nT` (n, 3): prediction of the fitted base; `predicted_nT` (n, 3):
    prediction of the given model. `beyond_nT` (n, 3): the part of `clean_nT` by effects beyond iron, which the base
    does not scale. `inputs`: measured inputs, see `Effect.needs`. `still`: sensor at rest, y the measured axes about a
    constant. `relative`: the field is the reading of a reference magnetometer.
    """

    recording: Recording
    state: State
    base: Array
    target: Array
    sigma_nT: Array
    usable: Array
    turn: Array
    clean_nT: Array
    predicted_nT: Array
    inputs: frozenset[str]
    still: bool = False
    relative: bool = False
    output_axes: Array | None = None
    beyond_nT: Array | float = 0.0

    @property
    def known(self) -> Known:
        """What is known beside the recording."""
        return Known(**{field.name: getattr(self, field.name) for field in fields(Known)})

    @property
    def mode(self) -> Mode:
        """The comparison: of the axes, or of the field's strength."""
        return "vector" if self.output_axes is None else "strength"

    @property
    def offset_nT(self) -> Array:
        """Constant (3,) in nT of the fitted base: what is measured without a field."""
        return np.asarray((self.clean_nT - self.beyond_nT).mean(axis=0) - self.turn @ self.state.field_nT.mean(axis=0))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the compared outputs."""
        return ("x", "y", "z") if self.output_axes is None else ("strength", "dip")[: self.output_axes.shape[1]]

    @property
    def compared(self) -> str:
        """The comparison in words: "vector", "strength", "strength+dip"."""
        return self.mode if self.output_axes is None else "+".join(self.outputs)

    @property
    def compares_across(self) -> bool:
        """Whether components across the field are compared too, so that attitude errors are observable."""
        return self.level is not None or self.along_attitude

    @property
    def along_attitude(self) -> bool:
        """Whether the axes are compared along a recorded attitude: not at rest, nor beside a reference."""
        return self.mode == "vector" and not (self.still or self.relative)

    @property
    def fitted(self) -> int:
        """Number of coefficients of the base."""
        each = int(self.base.shape[-1])
        return each * self.target.shape[1] if self.base.ndim == 2 else each

    @property
    def off_nT(self) -> Array:
        """Deviation in nT from the base: of the strength (n, 1) in strength mode, else of the axes (n, 3)."""
        if self.mode == "strength":
            return np.asarray(self.target[:, :1] * self.sigma_nT[:1])
        return np.asarray(self.recording.mag_nT - self.clean_nT)

    @cached_property
    def integrated_nT(self) -> Array:
        """Prediction (n, 3) of the base, integrated from the field's rate within each section between pauses."""
        rate = self.state.field_rate_nT_s @ self.turn.T
        parts = ((self.clean_nT[one.start], rate[one], self.state.time_s[one]) for one in self.sections)
        each = [start_nT + cumulative_trapezoid(r, time_s, axis=0, initial=0.0) for start_nT, r, time_s in parts]
        return np.concatenate(each)

    @cached_property
    def neighbour_nT(self) -> Array:
        """Prediction (n, 3) of the base from neighbouring samples, independent of a sample's own attitude error.

        An effect sensitive to small changes, as hysteresis at rest, would fit that error, which the residual contains.
        """
        return by_neighbours(self.clean_nT, self.state.time_s, self.policy.far_sigma * self.sigma_nT)

    @cached_property
    def sections(self) -> list[slice]:
        """Slices of samples between pauses; effects with memory start anew after each pause."""
        time_s = self.state.time_s
        ends = pauses_after(time_s, self.policy) + 1
        return [slice(int(a), int(b)) for a, b in itertools.pairwise([0, *ends, len(time_s)])]

    @property
    def turns(self) -> bool:
        """Whether the sensor is known to turn in the field."""
        field_nT = self.state.field_nT
        spread = np.linalg.norm(field_nT.std(axis=0)) / np.linalg.norm(field_nT[0])
        return self.along_attitude and bool(spread > self.policy.still_spread)

    @cached_property
    def direction(self) -> Array:
        """Direction (n, 3) of the undisturbed field."""
        field_nT = self.state.field_nT
        return np.asarray(field_nT / np.linalg.norm(field_nT, axis=1, keepdims=True))

    @cached_property
    def field_projection(self) -> Array:
        """Row vectors (n, 3) from a measurement to the field's component, ahead of the iron, along the field."""
        return np.asarray(self.direction @ np.linalg.inv(self.turn))

    def ahead_of_iron(self, measured_nT: Array) -> Array:
        """Differences (n, 3) of the field that make differences (n, 3) of the measurement, behind the fitted iron."""
        return np.asarray(measured_nT @ np.linalg.pinv(self.turn, rcond=1e-9).T)

    def missing_inputs(self, effect: type[Effect] | Effect) -> tuple[str, ...]:
        """Inputs that an effect needs and the problem lacks, or does not show.

        A field that changes in time changes the strength at any attitude.
        """
        needs = set(effect.needs)
        if self.mode != "strength":
            return tuple(sorted(needs - self.inputs))
        of_time = effect.traits.field_source and needs == {"attitude"}
        return () if of_time else tuple(sorted(needs - (self.inputs - IN_EARTH_FRAME)))

    def matrix_behind(self, effect: type[Effect]) -> Array:
        """Matrix (3, 3) from an effect's contribution, at its place in the chain, to the measured field.

        Contributions to the Earth's field pass the fitted iron, all others the model's effects behind their place:
        fitted differences from the model count as vehicle iron, as does all iron without a model.
        """
        return self.turn if effect.stage == "field" else self._iron_about(effect)[1]

    def input_nT(self, effect: type[Effect]) -> Array:
        """Input signal (n, 3) of an effect: for sensor and electronics, the prediction of the base.

        For effects of field and vehicle, the field behind the model's preceding effects, constants excepted.
        """
        if effect.stage not in ("field", "vehicle"):
            return self.clean_nT
        return np.asarray(self.state.field_nT @ self._iron_about(effect)[0].T)

    def _iron_about(self, effect: type[Effect]) -> tuple[Array, Array]:
        """Matrices (3, 3) of the model's iron ahead of an effect's place in the chain, and behind."""
        place = chain_position(self.effects, effect.name)
        return iron_matrix(self.effects[:place], self.state), iron_matrix(self.effects[place:], self.state)

    @cached_property
    def fitted_iron(self) -> tuple[Effect, Effect]:
        """Soft and hard iron that, inserted into the model's chain, make its iron equivalent to the fitted base.

        ``turn = B (I + S) A`` with the model's axes A ahead of the soft iron S and B behind. Clipped to their bounds,
        which a direction hardly shown by the motion may exceed.
        """
        ahead, behind = self._iron_about(SOFT)
        soft = _within_bounds(SOFT, np.linalg.inv(behind) @ self.turn @ np.linalg.inv(ahead) - np.eye(3))
        iron = insert_effects([effect for effect in self.effects if effect.traits.absorbed], [soft])
        modelled_nT = apply_deterministic(iron, self.state)[0].mean(axis=0)
        missing_nT = self.offset_nT + self.turn @ self.state.field_nT.mean(axis=0) - modelled_nT
        return soft, _within_bounds(HARD, np.linalg.inv(self.matrix_behind(HARD)) @ missing_nT)

    def whitened(self, contribution_nT: Array, effect: type[Effect] | None = None) -> Array:
        """Columns E (n, q, k) of contributions (n, 3, k) at an effect's place in the chain, in units of the noise.

        Without an effect the contributions are to the field in the body frame.
        """
        matrix = self.turn if effect is None else self.matrix_behind(effect)
        if self.output_axes is None:
            along = np.broadcast_to(matrix, (len(contribution_nT), 3, 3))
        else:
            ahead = self.output_axes.reshape(-1, 3) @ (np.linalg.inv(self.turn) @ matrix)
            along = ahead.reshape(self.output_axes.shape)
        return parts_along(along, contribution_nT, self.usable, self.sigma_nT)

    def earth_axes(self) -> Array:
        """Columns (n, q, 3) of a unit field along east, north and up."""
        return self.whitened(self.state.R_wb.transpose(0, 2, 1))

    def sensor_axes(self, course: Array) -> Array:
        """Columns (n, q, 3) of a course (n,) along each sensor axis, where an effect of a channel acts in the chain."""
        return self.whitened(course[:, None, None] * np.eye(3), FOLLOWS_CHANNEL)

    def without(self, samples: NDArray[np.bool_]) -> LinearProblem:
        """The problem with some samples (n,) marked unusable."""
        keep = self.usable * ~samples
        base = self.base * keep.reshape(-1, *[1] * (self.base.ndim - 1))
        return replace(self, base=base, target=self.target * keep[:, None], usable=keep)


def _within_bounds(iron: type[Effect], values: Array) -> Effect:
    parameter = iron.parameters()[0]
    value: Any = np.clip(values, parameter.low, parameter.high).tolist()
    return iron(**{parameter.name: value})


def about_model_effects(pose: Callable[[Array | float], LinearProblem]) -> LinearProblem:
    """The problem about what the model's effects add (n, 3) beyond its iron, each behind the fitted iron.

    Effects without recorded inputs, random effects and effects of the converter are left out.
    """
    problem, added_nT = pose(0.0), np.zeros((1, 3))
    known = [each for each in problem.effects if not (problem.missing_inputs(each) or each.traits.converter)]
    beyond_iron = any(not effect.traits.absorbed and not effect.stochastic for effect in known)
    for _ in range(STEPS if beyond_iron else 0):
        chain = insert_effects(known, problem.fitted_iron)
        both = (chain, [effect for effect in chain if effect.traits.absorbed])
        with_effects_nT, iron_nT = (apply_deterministic(effects, problem.state)[0] for effects in both)
        before_nT, added_nT = added_nT, with_effects_nT - iron_nT
        if (np.abs(added_nT - before_nT) < SETTLED * problem.sigma_nT.min()).all():
            break
        problem = pose(added_nT)
    return problem


@kernel
def parts_along(along: Array, vectors: Array, usable: Array, sigma: Array) -> Array:
    """``usable[n] / sigma[q] sum_i along[n, q, i] vectors[n, i, k]`` (n, q, k)."""
    n, q, _ = along.shape
    k = vectors.shape[2]
    out = np.empty((n, q, k))
    for i in range(n):
        for a in range(q):
            size = usable[i] / sigma[a]
            x, y, z = along[i, a, 0] * size, along[i, a, 1] * size, along[i, a, 2] * size
            for j in range(k):
                out[i, a, j] = x * vectors[i, 0, j] + y * vectors[i, 1, j] + z * vectors[i, 2, j]
    return out
