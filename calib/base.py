"""The base of all calibrators: it owns the checks, the timing and the status; a subclass solves."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, final

import numpy as np

from calib.acceptance import (
    CorrectedField,
    Extents,
    extents,
    flat_status,
    judgement,
    measured,
    own_reference,
    planar,
    residual_of,
    widened,
)
from calib.models.inputs import input_groups
from calib.numerics.points import ranges
from calib.numerics.rates import world_to_body
from calib.observability import motion_status
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.robust import without_wild
from calib.scale import field_factor, in_unit_of, magnified
from calib.settings import NotNegative, check
from recordings import Recording

CONSTANT_FRACTION = 1e-9
"""Measurements that vary by less than this fraction of their largest value are constant."""
ATTITUDE_STD_RAD = 3.5e-4

TIMES_TO_LOG = "log the time of each sample, or name its column with --map time_s=COLUMN"

NEEDS: dict[str, tuple[Callable[[Recording, Reference], object], str]] = {
    "attitude": (lambda recording, _: recording.att_q, "the attitude: record att_qw, att_qx, att_qy, att_qz"),
    "gyro": (lambda recording, _: recording.gyro_rad_s, "the body rate: record gyro_{x,y,z}_rad_s"),
    "accel": (lambda recording, _: recording.accel_m_s2, "the specific force: record accel_{x,y,z}_m_s2"),
    "scalar": (
        lambda recording, _: recording.channels.get("scalar_nT"),
        "a scalar magnetometer beside the vector one: record its field strength as scalar_nT",
    ),
    "input": (
        lambda recording, _: next((one.signals for one in input_groups(recording)), None),
        "an input that moves the field: record current_1_A ... in A, throttle, motor_output_1 ... or temperature_degC",
    ),
    "array": (lambda recording, _: recording.array_mag_nT, "an array of magnetometers: record mag1_x_nT ... mag4_z_nT"),
    "field_vector": (
        lambda _, reference: reference.field_enu_nT,
        "the field vector: give it as east, north, up, or place and date of the survey",
    ),
}
"""What a calibrator can need beside the field's strength: how to find it, and what to say when it is missing."""
VECTOR = {"attitude", "field_vector"}
"""Needs of a method that fits the field vector in the body frame; methods without them fit the strength."""


@dataclass(frozen=True)
class Calibrator(ABC):
    """A calibration method: a frozen dataclass of hyperparameters with a method `_solve`.

    The type of a hyperparameter defines the permitted values (`calib.settings`); others are refused with InputError.

    A subclass defines `name`, `summary` (one line), `_solve`, and where they differ from the default: `needs` (keys of
    NEEDS), `min_samples`, `sequential` (the order of the samples matters; the base leaves the claimed covariance
    unchanged), `whole_array` (takes all sensors of an array at once), `triangular` (the corrected field is in the frame
    of sensor 1, whose matrix is upper triangular), `one_axis` (made for a turn about one axis, with measurements in a
    plane), `own_judgement` (the method's own status and covariance are final), `carries` (the gyro links the samples: a
    measurement left out is NaN in `_solve`, and the sample's other columns are kept), `eddy` (B is fitted too; a fact
    of the class or a hyperparameter). The bound follows the fitted parameters.

    The base class checks the input, the excitation, the computation and the result (`calib.acceptance`). A fitted
    parameter `noise_std_nT`, the noise of a measured component, distinguishes motion from noise. `attitude_std_rad`:
    the attitude's error; where the attitude is used, motion smaller than five times the error is no excitation.
    `robust`: wild values, single samples that stand out from their neighbours, are left out (`calib.robust`).
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    min_samples: ClassVar[int] = 9
    sequential: ClassVar[bool] = False
    whole_array: ClassVar[bool] = False
    triangular: ClassVar[bool] = False
    one_axis: ClassVar[bool] = False
    own_judgement: ClassVar[bool] = False
    carries: ClassVar[bool] = False
    attitude_std_rad: NotNegative = field(default=ATTITUDE_STD_RAD, kw_only=True)
    robust: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        """Raise InputError for a hyperparameter outside the values of the type."""
        check(self, self.name)

    @final
    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Calibration:
        """Fit m = S h + b (+ B dh/dt) to a recording, which is never modified.

        The status of the result reports an unusable recording, an insufficient motion or a numerical failure; rng
        (default: seed 0) matters to stochastic methods only.
        """
        start = time.perf_counter()
        status = self._usable(recording, reference)
        if status is not None:
            return self._failed(status)
        result = self._robust(recording, reference, rng or np.random.default_rng(0))
        return replace(result, name=self.name, wall_s=time.perf_counter() - start)

    @final
    def fit_unchecked(
        self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None
    ) -> Calibration:
        """The method's result as `fit`, but with the claimed covariance and status unchanged."""
        start = time.perf_counter()
        status = self._usable(recording, reference)
        result = self._failed(status) if status else self._plain(recording, reference, rng or np.random.default_rng(0))
        return replace(result, name=self.name, wall_s=time.perf_counter() - start)

    def _plain(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        """The method's own result, by measurements of the field's size."""
        factor = self._factor(recording, reference)
        solved = self._solve(read_only(magnified(recording, factor)), reference, rng)
        return in_unit_of(self._failed(solved) if isinstance(solved, Status) else solved, factor)

    @abstractmethod
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        """Solve for the calibration, on a recording with all needed columns; a status where there is no estimate."""

    def _failed(self, status: Status, history: tuple[float, ...] = ()) -> Calibration:
        return Calibration(name=self.name, status=status, history=history)

    def _robust(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        """The method's result, wild values left out, see `calib.robust`."""

        def fit(part: Recording) -> Calibration:
            return self._guarded(part, reference, rng)

        result = fit(recording)
        if not self.robust or "scalar" in self.needs:
            return result
        return without_wild(result, recording, reference, fit, vector=self._fits_vector, carries=self.carries)

    def _guarded(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        """The method's result after all checks; not converged after a numerical failure.

        Solved and judged by measurements of the field's size, see `calib.scale`.
        """
        try:
            with np.errstate(divide="raise", invalid="raise", over="raise"):
                seen = measured(recording) if self.carries else recording
                factor = self._factor(seen, reference)
                whole, seen = (read_only(magnified(part, factor)) for part in (recording, seen))
                sensors = extents(seen) if self._fits_strength else ()
                unexcited = self._unexcited(seen, reference, sensors)
                solved = unexcited or self._solve(whole, reference, rng)
                return in_unit_of(self._checked(solved, seen, reference, sensors), factor)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            return self._failed(Status("not_converged", f"the computation broke down: {error}"))

    def _checked(
        self, solved: Calibration | Status, recording: Recording, reference: Reference, sensors: Extents
    ) -> Calibration:
        """The result with the accepted status."""
        result = self._failed(solved) if isinstance(solved, Status) else solved
        if not _finite(result):
            return self._failed(Status("not_converged", "the computation gave values that are not finite"))
        if self.own_judgement or result.status.kind == "not_applicable":
            return result
        judged_by = reference if self._fits_vector else own_reference(result, reference)
        return self._judged(result, recording, judged_by, sensors)

    def _judged(self, result: Calibration, recording: Recording, reference: Reference, sensors: Extents) -> Calibration:
        """The result, with the covariance scaled for a coloured residual and the status lowered where needed.

        A sequential method keeps its claimed covariance. Residual and matrix of the vector field do not apply to
        a method for the scalar magnetometer.
        """
        residual_nT = residual_of(result, recording, reference, vector=self._fits_vector)
        flat = flat_status(result, sensors, residual_nT)
        if flat is not None:
            return self._failed(flat, result.history)
        if result.status.kind == "unobservable":
            return result
        field = CorrectedField(result, recording, reference.strength_nT)
        if not self.sequential:
            result = widened(result, residual_nT, field, reference, vector=self._fits_vector)
        if "scalar" in self.needs:
            return result
        worse = judgement(result, residual_nT, field, reference, vector=self._fits_vector)
        if worse is None or (worse.kind == result.status.kind and worse.kind != "ok"):
            return result
        return replace(result, status=worse)

    @property
    def _fits_vector(self) -> bool:
        """Whether the field vector in the body frame is known, not the strength alone."""
        return set(self.needs) >= VECTOR

    @property
    def _fits_strength(self) -> bool:
        """Whether the field's strength alone is known, in a motion about all axes."""
        return not (self._fits_vector or self.one_axis)

    def _factor(self, recording: Recording, reference: Reference) -> float:
        """Factor from the measurements to the field's size; 1 for a method that takes directions alone from them."""
        if "scalar" in self.needs:
            return 1.0
        return field_factor(recording, reference, vector=self._fits_vector, one_axis=self.one_axis)

    def _unexcited(self, recording: Recording, reference: Reference, sensors: Extents) -> Status | None:
        """Unobservable when the measurements lie in a plane, or the known field moves less than the attitude error."""
        if self.one_axis or not self._fits_vector:
            return planar(sensors)
        assert recording.att_q is not None
        field_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        return motion_status(field_nT, reference.strength_nT, self.attitude_std_rad)

    def _usable(self, recording: Recording, reference: Reference) -> Status | None:
        if len(recording) < self.min_samples:
            return Status(
                "not_applicable",
                f"{self.name} needs at least {self.min_samples} samples, "
                f"the recording has {len(recording)}: record longer",
            )
        by_time = self.sequential or "gyro" in self.needs or getattr(self, "eddy", False)
        if by_time and not recording.origin.timed:
            return Status("not_applicable", f"{self.name} needs times: {TIMES_TO_LOG}")
        return unusable(recording, reference, self.needs, self.name) or _constant(recording)


def unusable(recording: Recording, reference: Reference, needs: Iterable[str], who: str) -> Status | None:
    """Not applicable where one of `needs` (keys of NEEDS) is missing or not finite."""
    used: dict[str, object] = {"time_s": recording.time_s, "mag_nT": recording.mag_nT}
    for need in needs:
        find, what = NEEDS[need]
        used[need] = find(recording, reference)
        if used[need] is None:
            return Status("not_applicable", f"{who} needs {what}")
    for name, values in used.items():
        bad = int(np.count_nonzero(~np.isfinite(np.asarray(values, dtype=float))))
        if bad:
            return Status("not_applicable", f"{name} has {bad} values that are not finite: leave those samples out")
    return None


def _constant(recording: Recording) -> Status | None:
    lowest, highest = ranges(np.ascontiguousarray(recording.mag_nT))
    if (highest - lowest).max() > CONSTANT_FRACTION * max(-lowest.min(), highest.max()):
        return None
    return Status("unobservable", "the measured field does not change: turn the vehicle about all its axes")


def read_only(recording: Recording) -> Recording:
    """The recording with write-protected views of all arrays."""
    views: dict[str, Any] = {}
    for item in fields(recording):
        value = getattr(recording, item.name)
        if isinstance(value, np.ndarray):
            views[item.name] = value.view()
            views[item.name].flags.writeable = False
    return replace(recording, **views)


def _finite(result: Calibration) -> bool:
    arrays = (result.offset_nT, result.matrix, result.eddy_s, result.covariance, list(result.parameters.values()))
    return all(bool(np.isfinite(a).all()) for a in arrays if a is not None)
