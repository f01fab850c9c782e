"""Sensor model about a calibration, linear in offset, matrix and disturbances.

m = s + sum_j d_j + B dh/dt + c S d2h/dt2 + v,  s = S h + b;  d_j: curves of the axes, and vectors that currents and a
temperature scale;  B: eddy currents and a delay, dh/dt = -omega x h;  c: a low-pass filter

With attitude and field vector h is known; else |h| = F, and only the misfit along a, the gradient of |h|, is seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import Calibration, Reference
from calib.held_out.legs import LegPartition
from calib.input_terms import InputTerm
from calib.models.ellipsoid import FULL_SLOTS, SYMMETRIC_SLOTS
from calib.models.inputs import Kind, input_groups
from calib.numerics.points import lengths
from calib.numerics.rates import body_rate, world_to_body
from recordings import Recording
from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT

IRON, CURVES, MOTORS, WARMTH, TURNING = "iron", "characteristic", "motors", "temperature", "eddy currents"
"""Groups of parameters."""
CURVE_TERMS = 6
"""Quadratic and cubic terms of the three axes."""
EDDY_TERMS = 10
"""Entries of B, and the factor of d2h/dt2 of a low-pass filter."""
STILL_RAD_S = 1e-3
"""Rms body rate below which B is not looked for."""


@dataclass(frozen=True, eq=False)
class InputSignal:
    """Change (n,) of an input over its rms, its group, and what the base takes off for a unit rms change, nT (3,)."""

    group: str
    change: Array
    taken_nT: Array


@dataclass(frozen=True, eq=False)
class SensorModel:
    """The model about a base calibration, S (3, 3) and offset_nT b (3,) with the mean field of its inputs.

    Parameters: b, F times the entries of S by slots (k, 3, 3), curves at full scale, vectors for a unit rms change, and
    B times F and the rms rate, all in nT and beyond the base's. vector : whether attitude and field vector are known.
    """

    base: Calibration
    offset_nT: Array
    S: Array
    slots: Array
    reference: Reference
    vector: bool
    signals: tuple[InputSignal, ...]
    turning: BodyTurning | None = None

    @classmethod
    def about(
        cls,
        base: Calibration,
        recording: Recording,
        reference: Reference,
        terms: Sequence[InputTerm] = (),
        *,
        vector: bool,
    ) -> SensorModel:
        """Return the model about a calibration, with the currents and the temperature of its recording.

        terms : of inputs that a calibrator has found, with their lags, in place of the inputs as logged.
        """
        slots = FULL_SLOTS if vector else SYMMETRIC_SLOTS
        S, mean = np.asarray(np.linalg.inv(base.matrix)), at_mean_inputs(base, recording)
        signals = signals_of(recording, terms, base)
        return cls(base, mean.offset_nT, S, slots, reference, vector, signals, BodyTurning.of(recording))

    @property
    def groups(self) -> tuple[str, ...]:
        """Return the group of each parameter."""
        return (
            *(IRON,) * (3 + len(self.slots)),
            *(CURVES,) * CURVE_TERMS,
            *(one.group for one in self.signals for _ in range(3)),
            *((TURNING,) * EDDY_TERMS if self.turning is not None else ()),
        )

    @property
    def taken(self) -> Array:
        """Return the parameters (k,) of the disturbances that the base takes off."""
        taken = np.zeros(len(self.groups))
        first = 3 + len(self.slots) + CURVE_TERMS
        moved = [one.taken_nT for one in self.signals]
        taken[first : first + 3 * len(moved)] = np.array(moved).ravel()
        if self.turning is not None and self.base.eddy_s is not None:
            eddy_nT = self.base.eddy_s * self.reference.strength_nT * self.turning.rms_rad_s
            taken[-EDDY_TERMS : -EDDY_TERMS + 9] = eddy_nT.ravel()
        return taken

    def squares(self, recording: Recording, legs: LegPartition) -> Array:
        """Return the squares (legs, k + 1, k + 1) of columns and misfit in each leg."""
        seen = self.base.apply(recording)
        return legs.squares(lambda block: self._rows(recording.taken(block), seen[block], block))

    @property
    def width(self) -> int:
        """Return the number of parameters, and one for the misfit."""
        return len(self.groups) + 1

    @property
    def rows_per_sample(self) -> int:
        """Return three for a known field vector, else one."""
        return 3 if self.vector else 1

    @property
    def curve_scale(self) -> float:
        """Return what S h is divided by in the curves c^2 and c^3, c within 1."""
        return self.reference.strength_nT * float(np.linalg.norm(self.S, 2))

    def _rows(self, part: Recording, seen: Array, samples: slice) -> Array:
        """Return columns and misfit (n, r, k + 1) of some samples; seen (n, 3) : their field by the base."""
        along, misfit, h = self._known(part, seen) if self.vector else self._of_strength(seen)
        entries = np.einsum("kij,nj->nik", self.slots, h / self.reference.strength_nT)
        c = (h @ self.S.T / self.curve_scale)[:, None]
        more = [along * one.change[samples, None, None] for one in self.signals]
        if self.turning is not None:
            first, second = self.turning.derivatives(samples, h / self.reference.strength_nT)
            more.append((along[..., None] * first[:, None, None]).reshape(*along.shape[:2], 9))
            more.append(along @ (second @ self.S.T)[:, :, None])
        columns = [along, along @ entries, along * c**2, along * c**3, *more, misfit[:, :, None]]
        return np.concatenate(columns, axis=2)

    def _of_strength(self, h: Array) -> tuple[Array, Array, Array]:
        """Return a / |a| (n, 1, 3), (|h| - F) / |a| (n, 1), and the field (n, 3) at the length F."""
        A, F = np.linalg.inv(self.S), self.reference.strength_nT
        size = lengths(h)
        unit = h / size[:, None]
        a = unit @ A
        gain = lengths(a)
        return (a / gain[:, None])[:, None], ((size - F) / gain)[:, None], F * unit

    def _known(self, part: Recording, seen: Array) -> tuple[Array, Array, Array]:
        """Return the identity (n, 3, 3), the misfit (n, 3) of the measurement, and the known field (n, 3)."""
        assert part.att_q is not None
        h = world_to_body(part.att_q, np.array(self.reference.field_enu_nT))
        axes = np.broadcast_to(np.eye(3), (len(h), 3, 3))
        return axes, (seen - h) @ self.S.T, h


@dataclass(frozen=True, eq=False)
class BodyTurning:
    """Body rate and its change (n, 3) in units of the rms rate and of the square."""

    rate: Array
    change: Array
    rms_rad_s: float

    @classmethod
    def of(cls, recording: Recording) -> BodyTurning | None:
        """Return the turning of a recording; None where it is not known or the body is still."""
        rate = body_rate(recording) if recording.origin.timed and len(recording) > 2 else None
        rms = 0.0 if rate is None else float(np.sqrt(np.mean(np.sum(rate**2, axis=1))))
        if rate is None or not (np.isfinite(rms) and rms > STILL_RAD_S):
            return None
        return cls(rate / rms, np.gradient(rate, recording.time_s, axis=0) / rms**2, rms)

    def derivatives(self, samples: slice, h: Array) -> tuple[Array, Array]:
        """Return dh/dt = -w x h and d2h/dt2 = w x (w x h) - dw/dt x h (n, 3) of a constant field in the body."""
        first = -np.cross(self.rate[samples], h)
        return first, -np.cross(self.rate[samples], first) - np.cross(self.change[samples], h)


def at_mean_inputs(fit: Calibration, recording: Recording) -> Calibration:
    """Return a calibration with the mean field of its inputs in the offset, where the model's offset has it."""
    if not fit.inputs or not fit.has_estimate:
        return fit
    mean_nT = np.sum([term.field(recording).mean(axis=0) for term in fit.inputs], axis=0)
    return replace(fit, offset_nT=np.asarray(fit.offset_nT) + mean_nT)


def signals_of(recording: Recording, terms: Sequence[InputTerm], base: Calibration) -> tuple[InputSignal, ...]:
    """Return the signals of the terms, and of inputs in whose group no term is; constant ones left out."""
    found = [(group_of(term.channel), term.moved(recording), term.channel) for term in terms]
    named = {name for name, _, _ in found}
    found += [(name, values, "") for name, values in _logged(recording) if name not in named]
    gains = {term.channel: term.gain_nT for term in base.inputs}
    made = (_signal(name, values, gains.get(channel, np.zeros(3))) for name, values, channel in found)
    return tuple(one for one in made if one is not None)


def group_of(channel: str) -> str:
    """Return the group of an input by its channel."""
    return WARMTH if channel == TEMPERATURE else MOTORS


def _logged(recording: Recording) -> Iterator[tuple[str, Array]]:
    """Yield group and signal of the currents' sum, else of a command, else of each motor; of the temperature."""
    groups = {one.kind: one for one in reversed(input_groups(recording)) if one.varies}
    power: tuple[Kind, ...] = ("battery", "throttle", "motors", "outputs")
    for kind in (next((one for one in power if one in groups), None), "temperature"):
        for values in groups[kind].signals.T if kind in groups else ():
            yield WARMTH if kind == "temperature" else MOTORS, values


def _signal(group: str, values: Array, gain_nT: Array) -> InputSignal | None:
    """Return the signal of values (n,); None where they are constant or not finite."""
    off = values - values.mean()
    rms = float(np.sqrt(np.mean(off**2)))
    return InputSignal(group, off / rms, gain_nT * rms) if np.isfinite(rms) and rms > ASSESSMENT.varies else None
