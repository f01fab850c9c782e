"""The measured recording beside what the model says along the same motion, as one linear problem."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from calib.numerics.noise import SECOND, clipped_mean, white_noise_std
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.level import Level
from diagnosis.problem.track import FieldTrack
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.chain_position import chain_position, iron_matrix
from sim.effects.kernels import kernel
from sim.state import State
from validation.signals.neighbours import by_neighbours

Mode = Literal["vector", "strength"]
LEAST_NOISE = 1e-6
"""What a residual that vanishes is measured by, nT."""


@dataclass(frozen=True)
class Instead:
    """What a given reference was found to be wrong in, and what was done: in a sentence, and with figures.

    field_enu_nT (3,): the field east, north, up that holds then.
    """

    words: str
    figures: str
    field_enu_nT: Array


@dataclass(frozen=True)
class LinearProblem:
    """A recording and a model, as ``y = B beta + E c + noise`` of q outputs a sample.

    mode "vector": q = 3, y the measured axes less a first fit of B = [predicted field, 1] on each axis: hard and soft
    iron fitted anew, which also takes up a fixed turn of the sensor. mode "strength": q = 1, y = |h| - F of the
    calibrated field h, B the nine changes of offset and symmetric matrix; with a `level` q = 2, the dip too, as an
    angle times F. `sight` (n, q, 3) are then the directions that the outputs are seen along. y (n, q) is divided by
    the noise of a sample, `sigma_nT` (q,); `base` B (n, p), of which each output has coefficients of its own, or
    (n, q, p), in units of the noise, where they have them in common; `usable` (n,) is 0 where a sample is no
    measurement (repeated, clipped, a spike), else 1.
    `turn` (3, 3): from the undisturbed to the measured field; `clean_nT` (n, 3): what the fitted base predicts;
    `predicted_nT` (n, 3): what the model as given predicts. `has`: what was measured, see `Effect.needs`.
    `attitude_std_rad`: the error of navigation's attitude that the model states, 0 if none. `iron_known`: whether the
    model's iron is the instrument's, so that a difference from it is a finding. `policy`: what is held for evidence.
    `still`: the sensor is at rest, and y is the measured axes about a constant. `relative`: the field is another
    magnetometer's reading. `instead`: what was done about a reference that was wrong. `track`: along which the
    field changes with the place. `level`: which way is down, where roll and pitch are known and the heading is not.
    """

    recording: Recording
    state: State
    effects: tuple[Effect, ...]
    mode: Mode
    base: Array
    target: Array
    sigma_nT: Array
    usable: Array
    turn: Array
    clean_nT: Array
    predicted_nT: Array
    has: frozenset[str]
    attitude_std_rad: float = 0.0
    iron_known: bool = True
    policy: Policy = STANDARD
    still: bool = False
    relative: bool = False
    instead: tuple[Instead, ...] = ()
    track: FieldTrack | None = None
    level: Level | None = None
    sight: Array | None = None

    @property
    def outputs(self) -> tuple[str, ...]:
        """What is compared of every sample, by name."""
        if self.sight is None:
            return ("x", "y", "z")
        return ("strength", "dip")[: self.sight.shape[1]]

    @property
    def compared(self) -> str:
        """The mode in words: "vector", "strength", "strength+dip"."""
        return self.mode if self.sight is None else "+".join(self.outputs)

    @property
    def sees_across(self) -> bool:
        """Whether what lies across the field is compared beside what lies along it: an error of the attitude shows."""
        return self.level is not None or (self.mode == "vector" and not self.still and not self.relative)

    @property
    def fitted(self) -> int:
        """How many coefficients the base has in all."""
        each = int(self.base.shape[-1])
        return each * self.target.shape[1] if self.base.ndim == 2 else each

    @property
    def off_strength_nT(self) -> Array:
        """By how much the strength is off (n, 1), where the heading is not known."""
        return np.asarray(self.target[:, :1] * self.sigma_nT[:1])

    @cached_property
    def course_nT(self) -> Array:
        """What the base predicts (n, 3), as the integral of the field's rate from each stretch's first value on."""
        rate = self.state.field_rate_nT_s @ self.turn.T
        parts = [
            self.clean_nT[one.start] + cumulative_trapezoid(rate[one], self.state.time_s[one], axis=0, initial=0.0)
            for one in self.stretches
        ]
        return np.concatenate(parts)

    @cached_property
    def beside_nT(self) -> Array:
        """What the base predicts (n, 3) by neighbouring samples, in which a sample's own attitude error has no part.

        What is left has that error. What holds on to small changes of the course, a loop while the vehicle rests,
        would explain it by itself.
        """
        return by_neighbours(self.clean_nT, self.state.time_s, self.policy.own_course * self.sigma_nT)

    @cached_property
    def stretches(self) -> list[slice]:
        """The samples between pauses: what remembers begins anew after each."""
        time_s = self.state.time_s
        ends = pauses_after(time_s, self.policy) + 1
        return [slice(int(a), int(b)) for a, b in itertools.pairwise([0, *ends, len(time_s)])]

    @property
    def turns(self) -> bool:
        """Whether it is known that the sensor turns in the field."""
        field_nT = self.state.field_nT
        spread = np.linalg.norm(field_nT.std(axis=0)) / np.linalg.norm(field_nT[0])
        return (
            self.mode == "vector" and not self.still and not self.relative and bool(spread > self.policy.still_spread)
        )

    @cached_property
    def direction(self) -> Array:
        """Direction (n, 3) of the undisturbed field."""
        field_nT = self.state.field_nT
        return np.asarray(field_nT / np.linalg.norm(field_nT, axis=1, keepdims=True))

    @cached_property
    def sees_along(self) -> Array:
        """What (n, 3) of a measured field makes its part along the undisturbed one, ahead of the iron."""
        return np.asarray(self.direction @ np.linalg.inv(self.turn))

    def turn_behind(self, effect: type[Effect]) -> Array:
        """Matrix (3, 3) from what an effect adds at its place in the chain to the measured field.

        The earth's field passes the fitted iron, all else what the model has behind it: what differs from the model
        is iron, and so is all of it where there is no model.
        """
        if effect.stage == "field":
            return self.turn
        return iron_matrix(self.effects[chain_position(self.effects, effect.name) :], self.state)

    def met_nT(self, effect: type[Effect]) -> Array:
        """The signal (n, 3) that an effect meets at its place in the chain: what the base predicts, for the sensor's.

        For those of field and vehicle the field behind what the model has ahead of them, but for constants.
        """
        if effect.stage not in ("field", "vehicle"):
            return self.clean_nT
        ahead = iron_matrix(self.effects[: chain_position(self.effects, effect.name)], self.state)
        return np.asarray(self.state.field_nT @ ahead.T)

    def whitened(self, contribution_nT: Array, effect: type[Effect]) -> Array:
        """Columns E (n, q, k) of contributions (n, 3, k) at an effect's place in the chain, in units of the noise."""
        turn = self.turn_behind(effect)
        if self.sight is None:
            along = np.broadcast_to(turn / self.sigma_nT[:, None], (len(contribution_nT), 3, 3))
            columns = parts_along(along, contribution_nT)
            columns *= self.usable[:, None, None]
            return columns
        return parts_along(self._along(turn), contribution_nT)

    def _along(self, turn: Array) -> Array:
        """The directions (n, q, 3) over the noise along which what passes a matrix is seen, 0 if not measured."""
        assert self.sight is not None
        key = turn.tobytes()
        if key not in self._directions:
            seen = self.sight * (self.usable[:, None] / self.sigma_nT)[:, :, None]
            self._directions[key] = np.ascontiguousarray(seen @ (np.linalg.inv(self.turn) @ turn))
        return self._directions[key]

    @cached_property
    def _directions(self) -> dict[bytes, Array]:
        """Those that were asked for, by the matrix."""
        return {}

    def without(self, samples: NDArray[np.bool_]) -> LinearProblem:
        """The same problem with some samples (n,) left out."""
        keep = self.usable * ~samples
        base = self.base * keep.reshape(-1, *[1] * (self.base.ndim - 1))
        return replace(self, base=base, target=self.target * keep[:, None], usable=keep)


def pauses_after(time_s: Array, policy: Policy) -> NDArray[np.intp]:
    """Indices of samples at times (n,) after which nothing was measured for `pause` intervals."""
    step = np.diff(time_s)
    return np.flatnonzero(step > policy.pause * np.median(step))


def sample_noise(residual: Array, gaps: NDArray[np.intp] | None = None) -> Array:
    """White noise (q,) of a residual (n, q) in which no motion is left; that of rounding at the least.

    gaps : samples after which a gap follows.
    """
    return np.maximum(white_noise_std(residual, gaps, orders=SECOND, pooled=clipped_mean), LEAST_NOISE)


@kernel
def parts_along(along: Array, vectors: Array) -> Array:
    """``sum_i along[n, q, i] vectors[n, i, k]`` (n, q, k)."""
    n, q, _ = along.shape
    k = vectors.shape[2]
    out = np.empty((n, q, k))
    for i in range(n):
        for a in range(q):
            x, y, z = along[i, a]
            for j in range(k):
                out[i, a, j] = x * vectors[i, 0, j] + y * vectors[i, 1, j] + z * vectors[i, 2, j]
    return out
