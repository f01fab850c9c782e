"""A recording compared with the model along the recorded motion, as one linear problem."""

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
from diagnosis.problem.given_field import FieldTrack, Level
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import chain_position, iron_matrix
from sim.effects.kernels import kernel
from sim.state import State
from validation.signals.neighbours import by_neighbours

Mode = Literal["vector", "strength"]
FOLLOWS_CHANNEL = next(effect for effect in EFFECTS if effect.with_role("channel"))
"""The effect that follows any channel."""
IN_EARTH_FRAME = frozenset({"attitude", "position"})
"""Inputs of effects that are not observable in the strength alone, nor between two magnetometers: common to both."""
LEAST_NOISE = 1e-6
"""Least noise in nT, for a vanishing residual."""


@dataclass(frozen=True)
class ReferenceCorrection:
    """An error of the given reference and its correction, as a sentence and as advice with figures.

    field_enu_nT (3,): the field east, north, up that holds after the correction; None if the given field still holds.
    """

    words: str
    figures: str
    field_enu_nT: Array | None = None


@dataclass(frozen=True)
class LinearProblem:
    """A recording and a model as ``y = B beta + E c + noise``, with q outputs for each sample.

    mode "vector": q = 3, y the measured axes less a first fit of B = [predicted field, 1] on each axis: hard and soft
    iron, including a fixed rotation of the sensor. mode "strength": q = 1, y = |h| - F of the calibrated field h, B the
    nine changes of offset and symmetric matrix; with a `level` q = 2, the second output being the dip as an angle times
    F. `output_axes` (n, q, 3): directions of the outputs in strength mode. y (n, q) is divided by the noise of a
    sample, `sigma_nT` (q,). `base` B: (n, p) with coefficients for each output, or (n, q, p) over the noise with shared
    coefficients. `usable` (n,): 0 for invalid samples (repeated, clipped, spikes), else 1. `turn` (3, 3): from the
    undisturbed to the measured field; `clean_nT` (n, 3): prediction of the fitted base; `predicted_nT` (n, 3):
    prediction of the given model. `beyond_nT` (n, 3): the part of `clean_nT` by effects beyond iron, which the base
    does not scale. `inputs`: measured inputs, see `Effect.needs`. `attitude_std_rad`: error of
    navigation stated by the model, 0 if none. `iron_known`: the model's iron is the instrument's, and a difference is a
    finding. `policy`: thresholds of the evidence. `still`: sensor at rest, y the measured axes about a constant.
    `relative`: the field is the reading of a reference magnetometer. `corrections`: corrections of a wrong reference.
    `track`: changes of the field with the place. `level`: vertical direction, where roll and pitch are known and the
    heading is not. `attitude_delay_s`: time by which the recorded attitude is late, stated by the model or found; the
    attitude of `recording` is moved by it. `left_out`: effects of the model that are looked for anew.
    `wrong_values`: rare wrong values were found and left out, of which those within the noise remain.
    """

    recording: Recording
    state: State
    effects: tuple[Effect, ...]
    base: Array
    target: Array
    sigma_nT: Array
    usable: Array
    turn: Array
    clean_nT: Array
    predicted_nT: Array
    inputs: frozenset[str]
    attitude_std_rad: float = 0.0
    iron_known: bool = True
    policy: Policy = STANDARD
    still: bool = False
    relative: bool = False
    corrections: tuple[ReferenceCorrection, ...] = ()
    track: FieldTrack | None = None
    level: Level | None = None
    output_axes: Array | None = None
    beyond_nT: Array | float = 0.0
    attitude_delay_s: float = 0.0
    left_out: tuple[Effect, ...] = ()
    wrong_values: bool = False

    @property
    def mode(self) -> Mode:
        """The comparison: of the axes, or of the field's strength."""
        return "vector" if self.output_axes is None else "strength"

    @property
    def offset_nT(self) -> Array:
        """Constant (3,) in nT of the fitted base: what is measured without a field."""
        return np.asarray((self.clean_nT - self.beyond_nT).mean(axis=0) - self.turn @ self.state.field_nT.mean(axis=0))

    @property
    def corrected_field_enu_nT(self) -> Array | None:
        """The field (3,) east, north, up that the last correction of the field found; None if the given one holds."""
        found = (done.field_enu_nT for done in reversed(self.corrections))
        return next((field_enu_nT for field_enu_nT in found if field_enu_nT is not None), None)

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
        return self.level is not None or (self.mode == "vector" and not self.still and not self.relative)

    @property
    def fitted(self) -> int:
        """Number of coefficients of the base."""
        each = int(self.base.shape[-1])
        return each * self.target.shape[1] if self.base.ndim == 2 else each

    @property
    def off_strength_nT(self) -> Array:
        """Error (n, 1) of the strength in nT, in strength mode."""
        return np.asarray(self.target[:, :1] * self.sigma_nT[:1])

    @cached_property
    def integrated_nT(self) -> Array:
        """Prediction (n, 3) of the base, integrated from the field's rate within each section between pauses."""
        rate = self.state.field_rate_nT_s @ self.turn.T
        parts = [
            self.clean_nT[section.start]
            + cumulative_trapezoid(rate[section], self.state.time_s[section], axis=0, initial=0.0)
            for section in self.sections
        ]
        return np.concatenate(parts)

    @cached_property
    def neighbour_nT(self) -> Array:
        """Prediction (n, 3) of the base from neighbouring samples, independent of a sample's own attitude error.

        The residual contains the sample's attitude error: an effect sensitive to small changes, as hysteresis at rest,
        would fit the error.
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
        return self.level is None and self.compares_across and bool(spread > self.policy.still_spread)

    @cached_property
    def direction(self) -> Array:
        """Direction (n, 3) of the undisturbed field."""
        field_nT = self.state.field_nT
        return np.asarray(field_nT / np.linalg.norm(field_nT, axis=1, keepdims=True))

    @cached_property
    def field_projection(self) -> Array:
        """Row vectors (n, 3) from a measurement to the field's component, ahead of the iron, along the field."""
        return np.asarray(self.direction @ np.linalg.inv(self.turn))

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
        if effect.stage == "field":
            return self.turn
        return iron_matrix(self.effects[chain_position(self.effects, effect.name) :], self.state)

    def input_nT(self, effect: type[Effect]) -> Array:
        """Input signal (n, 3) of an effect: for sensor and electronics, the prediction of the base.

        For effects of field and vehicle, the field behind the model's preceding effects, constants excepted.
        """
        if effect.stage not in ("field", "vehicle"):
            return self.clean_nT
        ahead = iron_matrix(self.effects[: chain_position(self.effects, effect.name)], self.state)
        return np.asarray(self.state.field_nT @ ahead.T)

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
        columns = parts_along(along, contribution_nT)
        columns *= (self.usable[:, None] / self.sigma_nT)[:, :, None]
        return columns

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


def pauses_after(time_s: Array, policy: Policy) -> NDArray[np.intp]:
    """Indices of samples at times (n,) followed by a pause of more than `pause` intervals."""
    step = np.diff(time_s)
    return np.flatnonzero(step > policy.pause * np.median(step))


def sample_noise(residual: Array, gaps: NDArray[np.intp] | None = None) -> Array:
    """White noise (q,) of a residual (n, q) without motion, at least `LEAST_NOISE`.

    gaps : indices of samples followed by a gap.
    """
    return np.maximum(white_noise_std(residual, gaps, orders=SECOND, pooled=clipped_mean), LEAST_NOISE)


def repeated(mag_nT: Array) -> NDArray[np.bool_]:
    """Mask (n,) of rows of values (n, 3) equal to the row before."""
    return np.asarray(np.concatenate([[False], (mag_nT[1:] == mag_nT[:-1]).all(axis=1)]), dtype=np.bool_)


def held(mag_nT: Array, residual: Array, policy: Policy) -> NDArray[np.bool_]:
    """Mask (n,) of repeated rows, where more frequent than rounding explains; residual (n, q): without motion.

    Two values with noise s round to one step d of a lattice with probability ``d / (2 sqrt(pi) s)``, at most 1.
    """
    again = repeated(mag_nT)
    if np.count_nonzero(again) < policy.least_spikes:
        return np.zeros(len(mag_nT), np.bool_)
    steps = np.array([np.diff(np.unique(axis)).min(initial=np.inf) for axis in mag_nT.T])
    chance = float(np.prod(np.minimum(1.0, steps / (2 * np.sqrt(np.pi) * sample_noise(residual)))))
    return again & (float(again.mean()) > policy.much_larger * chance)


def noise_of_neighbours(residual: Array, mag_nT: Array, time_s: Array, policy: Policy) -> Array:
    """White noise (q,) of a residual (n, q) without motion, from rows that are not repeated, and not across pauses.

    From all rows where too few are new: a noiseless vehicle at rest repeats every row.
    """
    fresh = ~held(mag_nT, residual, policy)
    sigma = sample_noise(residual[fresh], pauses_after(time_s[fresh], policy))
    return sigma if np.isfinite(sigma).all() else sample_noise(residual, pauses_after(time_s, policy))


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
