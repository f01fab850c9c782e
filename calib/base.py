"""The base of all calibrators: it owns the checks, the timing and the status; a subclass solves."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from calib.numerics.colour import inflation, lasting_nT2, residual_of
from calib.observability import covariance_status
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]
CONSTANT_FRACTION = 1e-9
"""A field that varies by less than this fraction of the strength is constant."""

NEEDS: dict[str, tuple[Callable[[Recording, Reference], object], str]] = {
    "attitude": (lambda recording, _: recording.att_q, "the attitude: record att_qw, att_qx, att_qy, att_qz"),
    "gyro": (lambda recording, _: recording.gyro_rad_s, "the body rate: record gyro_{x,y,z}_rad_s"),
    "accel": (lambda recording, _: recording.accel_m_s2, "the specific force: record accel_{x,y,z}_m_s2"),
    "scalar": (
        lambda recording, _: recording.channels.get("scalar_nT"),
        "a scalar magnetometer beside the vector one: record its field strength as scalar_nT",
    ),
    "array": (lambda recording, _: recording.array_mag_nT, "an array of magnetometers: record mag1_x_nT ... mag4_z_nT"),
    "field_vector": (
        lambda _, reference: reference.field_enu_nT,
        "the field vector: give it as east, north, up, or place and date of the survey",
    ),
}
"""What a calibrator can need beside the field's strength: how to find it, and what to say when it is missing."""


@dataclass(frozen=True)
class Calibrator(ABC):
    """A calibration method: a frozen dataclass of hyperparameters that writes `_solve`.

    Class attributes: `name` (fixed by DESIGN), `summary` (one line), `needs` (keys of NEEDS), `min_samples`,
    `sequential` (the order of the samples matters), `recovers` (the standard motions whose noise-free recording it
    must give back), `tolerance_nT` and `tolerance_matrix` (how closely; a turned frame or another unit may change a
    twentieth and a tenth of that), `unit_free` (no setting is in nT: data in another unit give the same result),
    `whole_array` (takes all sensors of an array at once), `triangular` (the corrected field is in the frame of sensor
    1, whose matrix is upper triangular).
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    min_samples: ClassVar[int] = 9
    sequential: ClassVar[bool] = False
    recovers: ClassVar[tuple[str, ...]] = ("full", "pitch", "auv")
    tolerance_nT: ClassVar[float] = 0.02
    tolerance_matrix: ClassVar[float] = 1e-6
    unit_free: ClassVar[bool] = True
    whole_array: ClassVar[bool] = False
    triangular: ClassVar[bool] = False

    @final
    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Calibration:
        """Fit m = S h + b (+ B dh/dt) to a recording, which is never modified.

        A recording that the method cannot use, a motion that says too little and a numerical failure are told by the
        result's status; rng (default: seed 0) matters to stochastic methods only.
        """
        start = time.perf_counter()
        status = self._usable(recording, reference)
        if status is not None:
            return self._failed(status)
        result = self._guarded(_read_only(recording), reference, rng or np.random.default_rng(0))
        return replace(result, name=self.name, wall_s=time.perf_counter() - start)

    @abstractmethod
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        """The method itself, on a recording that has all it needs; a status where there is no estimate."""

    def _guarded(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        try:
            with np.errstate(divide="raise", invalid="raise", over="raise"):
                solved = self._solve(recording, reference, rng)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            return self._failed(Status("not_converged", f"the computation broke down: {error}"))
        result = self._failed(solved) if isinstance(solved, Status) else solved
        if not _finite(result):
            return self._failed(Status("not_converged", "the computation gave values that are not finite"))
        if result.status.kind not in ("ok", "not_converged"):
            return result
        result = self._inflated(result, recording, reference)
        worse = covariance_status(result, reference.strength_nT)
        return result if worse is None else replace(result, status=worse)

    def _failed(self, status: Status) -> Calibration:
        return Calibration(name=self.name, status=status)

    def _inflated(self, result: Calibration, recording: Recording, reference: Reference) -> Calibration:
        """The result with its claimed covariance made true to coloured residuals, see `calib.numerics.colour`.

        With known attitude the residual is an offset's, so noise that lasts is added to the offset's covariance.
        A sequential filter is left alone: its process noise is in its covariance, and its last estimate need not fit
        the beginning of the recording.
        """
        if self.sequential or result.covariance is None or result.offset_covariance_nT2 is None:
            return result
        vector = {"attitude", "field_vector"} <= set(self.needs)
        residual_nT = residual_of(result, recording, reference, vector=vector)
        factor = inflation(residual_nT)
        covariance = factor * result.covariance
        if vector:
            offset = [result.covariance_names.index(name) for name in OFFSET_NAMES]
            S = np.linalg.pinv(result.matrix)
            covariance[np.ix_(offset, offset)] += S @ lasting_nT2(residual_nT) @ S.T
        parameters = result.parameters | {"covariance_inflation": factor}
        return replace(result, covariance=covariance, parameters=parameters)

    def _usable(self, recording: Recording, reference: Reference) -> Status | None:
        if len(recording) < self.min_samples:
            return Status(
                "not_applicable",
                f"{self.name} needs at least {self.min_samples} samples, "
                f"the recording has {len(recording)}: record longer",
            )
        used: dict[str, object] = {"time_s": recording.time_s, "mag_nT": recording.mag_nT}
        for need in self.needs:
            find, what = NEEDS[need]
            used[need] = find(recording, reference)
            if used[need] is None:
                return Status("not_applicable", f"{self.name} needs {what}")
        return _unusable_values(used) or _constant(recording, reference)


def _unusable_values(used: dict[str, object]) -> Status | None:
    for name, values in used.items():
        bad = int(np.count_nonzero(~np.isfinite(np.asarray(values, dtype=float))))
        if bad:
            return Status("not_applicable", f"{name} has {bad} values that are not finite: leave those samples out")
    return None


def _constant(recording: Recording, reference: Reference) -> Status | None:
    if np.ptp(np.ascontiguousarray(recording.mag_nT.T), axis=1).max() > CONSTANT_FRACTION * reference.strength_nT:
        return None
    return Status("unobservable", "the measured field does not change: turn the vehicle about all its axes")


def _read_only(recording: Recording) -> Recording:
    """The same recording through views that cannot be written to."""
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
