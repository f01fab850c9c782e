"""Is the reference itself wrong? A field with the wrong sign of its dip, a heading made from this magnetometer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.rotation import to_body
from sim.state import Array
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.linear import LinearProblem, sample_noise
from validation.signals.size import column_rms, rms

MISREAD = {
    "its vertical part has the other sign": np.diag([1.0, 1.0, -1.0]),
    "it is north, east, down": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
}
"""What may have been given in place of east, north, up: in words, and the matrix (3, 3) that makes it right."""


@dataclass(frozen=True)
class Misread:
    """A given field read in another way: how, the field (3,) then, and the gap before and after in nT."""

    how: str
    field_enu_nT: Array
    before_nT: float
    after_nT: float


def misread_field(problem: LinearProblem) -> Misread | None:
    """The way to read the given field that lowers the gap most, if by a large factor; in vector mode only.

    The gap is what a free matrix and offset leave of ``R_wb^T F``: hard and soft iron cannot take up a dip of the wrong
    sign in a motion that tilts.
    """
    if problem.mode != "vector" or problem.relative:
        return None
    given = problem.state.field_enu_nT
    before = _gap_nT(problem, given)
    read = [Misread(how, S @ given, before, _gap_nT(problem, S @ given)) for how, S in MISREAD.items()]
    best = min(read, key=lambda one: one.after_nT)
    return best if best.after_nT * problem.policy.misread_gap < before else None


def doubts_of_reference(problem: LinearProblem) -> tuple[str, ...]:
    """Why no effect may be named: what a field that was misread leaves resembles many."""
    misread = misread_field(problem)
    return () if misread is None else (f"the given field is misread: {misread.how}",)


@dataclass(frozen=True)
class East:
    """Noise of a sample and rms (nT) of what a calibration leaves: towards magnetic east, and along the field."""

    noise_nT: float
    rms_nT: float
    along_noise_nT: float
    along_rms_nT: float

    def is_silent(self, policy: Policy) -> bool:
        """Whether east has less noise than the sensor itself, and less of a gap."""
        quieter = self.noise_nT < policy.compass_noise * self.along_noise_nT
        return quieter and self.rms_nT < policy.compass_gap * self.along_rms_nT


def own_compass(problem: LinearProblem) -> East | None:
    """What shows that navigation's heading was computed from this magnetometer, None if nothing does.

    ``k . (D m - d) = 0`` for some D and d, ``k = R_wb^T e``, e magnetic east: that is what a tilt-compensated heading
    is made of, whatever calibration it was made with. D and d are the least right singular vector of these rows. An
    independent heading adds its noise to the sensor's, so that east is the noisier; one made from m leaves none there.
    In vector mode only, and where the motion determines D.
    """
    F = problem.state.field_enu_nT
    if problem.mode != "vector" or problem.relative or not np.hypot(*F[:2]):
        return None
    calibration: Array = np.asarray(np.linalg.pinv(problem.turn, rcond=1e-9), dtype=np.float64)
    towards_east = _east_nT(problem, calibration)
    if towards_east is None:
        return None
    used = problem.usable > 0
    left = (problem.recording.mag_nT - problem.clean_nT)[used] @ calibration.T
    along = np.einsum("ni,ni->n", problem.state.field_nT[used] / np.linalg.norm(F), left)
    parts = np.column_stack([towards_east, along])
    (noise, along_noise), (size, along_size) = sample_noise(parts), column_rms(parts)
    found = East(float(noise), float(size), float(along_noise), float(along_size))
    return found if found.is_silent(problem.policy) else None


def _east_nT(problem: LinearProblem, calibration: Array) -> Array | None:
    """``k . (D m - d)`` (n,) in nT for the D and d that make it least, D of the size of a calibration (3, 3)."""
    F, used = problem.state.field_enu_nT, problem.usable > 0
    k = to_body(problem.state.R_wb, np.array([[-F[1], F[0], 0.0]]) / np.hypot(*F[:2]))[used]
    m = problem.recording.mag_nT[used] / np.linalg.norm(F)
    turned = (k[:, :, None] * (m - m.mean(axis=0))[:, None, :]).reshape(len(k), 9)
    rows = np.concatenate([turned, k], axis=1)
    least = np.linalg.eigh(rows.T @ rows)[1][:, 0]
    D = least[:9].reshape(3, 3)
    if np.linalg.cond(D) > problem.policy.compass_condition * np.linalg.cond(calibration):
        return None
    return np.asarray(rows @ least * (np.linalg.norm(F) * np.linalg.norm(calibration) / np.linalg.norm(D)))


def _gap_nT(problem: LinearProblem, field_enu_nT: Array) -> float:
    """Rms (nT) that a free matrix and offset leave of the measured field."""
    used = problem.usable > 0
    base = np.column_stack([to_body(problem.state.R_wb, field_enu_nT[None]) / 1e4, np.ones(len(used))])[used]
    mag_nT = problem.recording.mag_nT[used]
    return rms(mag_nT - base @ np.linalg.lstsq(base, mag_nT, rcond=None)[0])
