"""Sensor model about a calibration, linear in offset, matrix and disturbances.

m = s + sum_j d_j + B dh/dt + v,  s = S h + b;  d_j: curves of the axes, and vectors that currents and a temperature
scale;  B: eddy currents, a delay and a low-pass filter, dh/dt = -omega x h

With attitude and field vector h is known; else |h| = F, and only the misfit along a, the gradient of |h|, is seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
EDDY_TERMS = 9
"""Entries of B."""
STILL_RAD_S = 1e-3
"""Rms body rate below which B is not looked for."""


@dataclass(frozen=True, eq=False)
class SensorModel:
    """The model about offset_nT b (3,) and S (3, 3); slots (k, 3, 3) of S.

    Parameters: b, F times the entries of S, curves at full scale, vectors for a unit rms change, and B times F and the
    rms rate, all in nT. vector : whether attitude and field vector are known. signals : group and standardised signal
    (n,) of disturbances. rate : body rate (n, 3) over its rms, None where not known.
    """

    offset_nT: Array
    S: Array
    slots: Array
    reference: Reference
    vector: bool
    signals: tuple[tuple[str, Array], ...]
    rate: Array | None = None

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
        S = np.asarray(np.linalg.inv(base.matrix))
        return cls(base.offset_nT, S, slots, reference, vector, signals_of(recording, terms), _rate(recording))

    @property
    def groups(self) -> tuple[str, ...]:
        """Return the group of each parameter."""
        return (
            *(IRON,) * (3 + len(self.slots)),
            *(CURVES,) * CURVE_TERMS,
            *(group for group, _ in self.signals for _ in range(3)),
            *((TURNING,) * EDDY_TERMS if self.rate is not None else ()),
        )

    def squares(self, recording: Recording, legs: LegPartition) -> Array:
        """Return the squares (legs, k + 1, k + 1) of columns and misfit in each leg."""
        ends = np.flatnonzero(np.diff(legs.number)) + 1
        parts = np.split(np.arange(len(recording)), ends)
        taken = (self._rows(recording.taken(slice(part[0], part[-1] + 1)), part) for part in parts)
        return np.array([rows.T @ rows for rows in (one.reshape(-1, self.width) for one in taken)])

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

    def _rows(self, part: Recording, samples: NDArray[np.intp]) -> Array:
        """Return columns and misfit (n, r, k + 1) of some samples."""
        along, misfit, h = self._known(part) if self.vector else self._of_strength(part)
        entries = np.einsum("kij,nj->nik", self.slots, h / self.reference.strength_nT)
        c = (h @ self.S.T / self.curve_scale)[:, None]
        more = [along * values[samples, None, None] for _, values in self.signals]
        if self.rate is not None:
            change = -np.cross(self.rate[samples], h / self.reference.strength_nT)
            more.append((along[..., None] * change[:, None, None]).reshape(*along.shape[:2], EDDY_TERMS))
        columns = [along, along @ entries, along * c**2, along * c**3, *more, misfit[:, :, None]]
        return np.concatenate(columns, axis=2)

    def _of_strength(self, part: Recording) -> tuple[Array, Array, Array]:
        """Return a / |a| (n, 1, 3), (|h| - F) / |a| (n, 1), and the field (n, 3) at the length F."""
        A, F = np.linalg.inv(self.S), self.reference.strength_nT
        h = (part.mag_nT - self.offset_nT) @ A.T
        size = lengths(h)
        unit = h / size[:, None]
        a = unit @ A
        gain = lengths(a)
        return (a / gain[:, None])[:, None], ((size - F) / gain)[:, None], F * unit

    def _known(self, part: Recording) -> tuple[Array, Array, Array]:
        """Return the identity (n, 3, 3), m - b - S h (n, 3), and the known field (n, 3)."""
        assert part.att_q is not None
        h = world_to_body(part.att_q, np.array(self.reference.field_enu_nT))
        axes = np.broadcast_to(np.eye(3), (len(h), 3, 3))
        return axes, part.mag_nT - self.offset_nT - h @ self.S.T, h


def signals_of(recording: Recording, terms: Sequence[InputTerm] = ()) -> tuple[tuple[str, Array], ...]:
    """Return group and standardised signal (n,) of the terms, and of inputs in whose group no term is."""
    found = [(group_of(term.channel), term.moved(recording)) for term in terms]
    named = {name for name, _ in found}
    found += [(name, values) for name, values in _logged(recording) if name not in named]
    return tuple((name, one) for name, values in found if (one := _standardised(values)) is not None)


def _rate(recording: Recording) -> Array | None:
    """Return the body rate (n, 3) over its rms; None where it is not known or the body is still."""
    rate = body_rate(recording) if recording.origin.timed else None
    rms = 0.0 if rate is None else float(np.sqrt(np.mean(np.sum(rate**2, axis=1))))
    return rate / rms if rate is not None and np.isfinite(rms) and rms > STILL_RAD_S else None


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


def _standardised(values: Array) -> Array | None:
    """Return values (n,) less their mean over their rms change; None where they are constant or not finite."""
    off = values - values.mean()
    rms = float(np.sqrt(np.mean(off**2)))
    return off / rms if np.isfinite(rms) and rms > ASSESSMENT.varies else None
