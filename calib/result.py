"""Result of a calibration: estimate, uncertainty, status."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from calib.input_terms import InputTerm
from calib.numerics.points import mapped, turning_field
from calib.numerics.rates import body_rate, smoothed_derivative
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError

Kind = Literal["ok", "not_converged", "unobservable", "not_applicable"]
OFFSET_NAMES = ("offset_x_nT", "offset_y_nT", "offset_z_nT")
STRENGTH_NAME = "strength_nT"
"""The parameter of a fit that finds the field's strength itself, in the scale of its matrix."""
SCALAR_TERM = "permanent_x_nT"
"""First parameter of a fit of the scalar magnetometer's terms; such a fit leaves the vector sensor as measured."""
DERIVATIVE_ROUNDS = 3
"""Rounds of the fixed point that finds h and dh/dt when no body rate is known."""


@dataclass(frozen=True)
class Status:
    """Outcome of a fit; a reason and a remedy for every kind but "ok", with "ok" possibly a caveat."""

    kind: Kind
    reason: str = ""

    @classmethod
    def settled(cls, settled: bool, otherwise: str) -> Status:
        """Ok, or not converged with the reason given."""
        return cls("ok") if settled else cls("not_converged", otherwise)


@dataclass(frozen=True, eq=False)
class Segment:
    """offset_nT (3,) and matrix (3, 3) from `start_s` of the recording's time on."""

    start_s: float
    offset_nT: Array
    matrix: Array


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Calibration:
    """A fitted measurement model and its inverse.

    m = S h + b + B dh/dt,  matrix = S^-1;  static case: h = matrix (m - b)

    m measured and h true field in the body frame, nT; `offset_nT` b (3,), `matrix` (3, 3), `eddy_s` B (3, 3) or None.
    `parameters` holds named values; `covariance` (p, p) belongs to the p of them listed in `covariance_names`.
    `history` is the method's own measure of convergence, a value a round. A fit without an estimate leaves b = 0 and
    matrix = I (the raw measurement), and `status` says why.

    A fit of a whole array of k sensors has `array_offset_nT` (k, 3) and `array_matrix` (k, 3, 3) too; offset_nT and
    matrix are then sensor 1's. The parameters of sensor 2 on have names that end in @2, ...

    A fit whose offset and matrix change with time has `segments`, in order of time; offset_nT and matrix are then their
    mean, and `apply` takes the segment that the sample's time is in (the first before it begins).

    `inputs`: terms of recorded inputs, see `calib.input_terms`, which `apply` takes off m.

    `left_out` (n,): the wild samples of the recording, which the fit has not used; None for none.
    """

    name: str
    status: Status
    offset_nT: Array = field(default_factory=lambda: np.zeros(3))
    matrix: Array = field(default_factory=lambda: np.eye(3))
    eddy_s: Array | None = None
    parameters: dict[str, float] = field(default_factory=dict)
    covariance: Array | None = None
    covariance_names: tuple[str, ...] = ()
    history: tuple[float, ...] = ()
    wall_s: float = 0.0
    array_offset_nT: Array | None = None
    array_matrix: Array | None = None
    segments: tuple[Segment, ...] = ()
    inputs: tuple[InputTerm, ...] = ()
    left_out: NDArray[np.bool_] | None = None

    def __repr__(self) -> str:
        """One line: name, status, offset and the matrix's diagonal."""
        reason = f" ({self.status.reason})" if self.status.reason else ""
        outcome = f"{self.name}: {self.status.kind}{reason}"
        if not self.has_estimate:
            return f"{outcome}, no estimate of offset and matrix"
        offset, diagonal = (", ".join(f"{v:.6g}" for v in values) for values in (self.offset_nT, np.diag(self.matrix)))
        return f"{outcome}, offset ({offset}) nT, matrix's diagonal ({diagonal})"

    @property
    def has_estimate(self) -> bool:
        """Whether offset and matrix are an estimate.

        A failed fit that left b = 0 and matrix = I has none, nor has a fit of the scalar magnetometer's terms.
        """
        if self.status.kind == "not_applicable":
            return False
        moved = bool(self.offset_nT.any()) or not np.array_equal(self.matrix, np.eye(3)) or self.eddy_s is not None
        return moved or (self.status.kind == "ok" and not self.corrects_scalar)

    @property
    def corrects_scalar(self) -> bool:
        """Whether the fit corrects the scalar magnetometer, the channel scalar_nT, in place of the vector one."""
        return SCALAR_TERM in self.parameters

    @property
    def determines_z(self) -> bool:
        """Whether the offset along z is estimated; a planar calibration claims those along x and y alone."""
        return OFFSET_NAMES[0] not in self.covariance_names or OFFSET_NAMES[2] in self.covariance_names

    @property
    def offset_covariance_nT2(self) -> Array | None:
        """Claimed covariance (3, 3) of the offset, nT^2; None where the method gives none."""
        if self.covariance is None or not set(OFFSET_NAMES) <= set(self.covariance_names):
            return None
        rows = [self.covariance_names.index(name) for name in OFFSET_NAMES]
        return self.covariance[rows][:, rows]

    def apply(self, recording: Recording) -> Array:
        """Calibrated field (n, 3), nT, body frame.

        Without eddy term h = matrix (m - b). With it dh/dt = -omega x h, so (S - B [omega]x) h = m - b is solved sample
        by sample, omega being the gyro's or else the attitude's derivative; without either dh/dt is the smoothed
        derivative of the field itself, found together with it by a few fixed-point rounds. The field of the inputs is
        taken off m first; InputError for a recording that lacks one.
        """
        measured_nT = recording.mag_nT
        for term in self.inputs:
            measured_nT = measured_nT - term.field(recording)
        if self.segments:
            return self._apply_segments(measured_nT, recording.time_s)
        if self.eddy_s is None:
            return np.asarray(mapped(np.ascontiguousarray(measured_nT), self.offset_nT, self.matrix))
        centred = measured_nT - self.offset_nT
        rate = body_rate(recording)
        if rate is None:
            return self._apply_by_derivative(centred, recording.time_s)
        return np.asarray(turning_field(centred, np.linalg.inv(self.matrix), self.eddy_s, np.ascontiguousarray(rate)))

    def used(self, recording: Recording) -> Recording:
        """The fitted recording without the samples left out."""
        return recording if self.left_out is None else recording.taken(~self.left_out)

    def apply_array(self, recording: Recording) -> Array:
        """Calibrated field (k, n, 3) of every sensor of an array, nT, all in one frame.

        Raises InputError when the fit or the recording is not of an array.
        """
        if self.array_offset_nT is None or self.array_matrix is None or recording.array_mag_nT is None:
            raise InputError(
                "no array of sensors to apply to",
                where=self.name,
                do="take a calibrator of whole arrays, and a recording with mag1_x_nT ... mag4_z_nT",
            )
        centred = recording.array_mag_nT - self.array_offset_nT[:, None, :]
        return np.asarray(np.einsum("kij,knj->kni", self.array_matrix, centred))

    def of_sensor(self, index: int) -> Calibration:
        """The calibration of a sensor (0-based) of an array, with plain parameter names."""
        if self.array_offset_nT is None or self.array_matrix is None:
            return self
        names = {name: plain for name in self.parameters if (plain := _plain_name(name, index)) is not None}
        own = [i for i, name in enumerate(self.covariance_names) if name in names]
        return replace(
            self,
            offset_nT=self.array_offset_nT[index],
            matrix=self.array_matrix[index],
            parameters={plain: self.parameters[name] for name, plain in names.items()},
            covariance=None if self.covariance is None else self.covariance[np.ix_(own, own)],
            covariance_names=tuple(names[self.covariance_names[i]] for i in own),
            array_offset_nT=None,
            array_matrix=None,
        )

    def static(self) -> Calibration:
        """The calibration with the mean of the segments and without inputs, for recordings of a different time."""
        return replace(self, segments=(), inputs=())

    def _apply_segments(self, measured_nT: Array, time_s: Array) -> Array:
        out = np.empty_like(measured_nT)
        starts_s = [segment.start_s for segment in self.segments[1:]]
        which = np.searchsorted(starts_s, time_s, side="right")
        for k, segment in enumerate(self.segments):
            out[which == k] = mapped(measured_nT[which == k], segment.offset_nT, segment.matrix)
        return out

    def _apply_by_derivative(self, centred: Array, time_s: Array) -> Array:
        assert self.eddy_s is not None
        h = centred @ self.matrix.T
        for _ in range(DERIVATIVE_ROUNDS):
            h = (centred - smoothed_derivative(h, time_s) @ self.eddy_s.T) @ self.matrix.T
        return np.asarray(h)


def _plain_name(name: str, index: int) -> str | None:
    """A parameter's name without @sensor when it is that sensor's, else None."""
    plain, _, sensor = name.partition("@")
    return plain if int(sensor or 1) == index + 1 else None
