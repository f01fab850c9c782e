"""Checks of the given reference: a field in wrong axes, a heading computed from the magnetometer under test."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.formulation import pose_again
from diagnosis.problem.given_field import Level
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection, sample_noise
from scenarios.arrays import Array
from sim.rotation import to_body
from validation.signals.amplitude import column_rms, rms
from validation.text import digits, figure

OWN_HEADING = "The heading was computed from this very magnetometer"
COMPASS = f"{OWN_HEADING}: only the field's strength and dip were compared."
STEEP = f"{OWN_HEADING}: only the field's strength was compared."
LEAST_SHOWN_NT = 0.01
"""Noise in nT below which a heading certainly comes from the magnetometer under test."""
MISREAD = {
    "its vertical part has the other sign": np.diag([1.0, 1.0, -1.0]),
    "it is north, east, down": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
}
"""Possible misreadings of east, north, up: description, and the matrix (3, 3) of the correction."""


def correct_reference(problem: LinearProblem) -> LinearProblem:
    """The problem, formulated again without a wrong reference, the corrections listed in `corrections`.

    A field in wrong axes is converted. A heading computed from the magnetometer under test is discarded: roll and pitch
    still give the vertical, so that strength and dip of the field are compared.
    """
    if (misread := find_misread_field(problem)) is not None:
        problem = pose_again(problem, problem.recording, misread.field_enu_nT, misread)
    if (east := find_own_compass(problem)) is not None:
        given, bare = problem.state.field_enu_nT, replace(problem.recording, att_q=None)
        level = Level.of(problem.state.R_wb, given, problem.policy)
        problem = pose_again(problem, bare, None, east.correction(given, STEEP if level is None else COMPASS), level)
    return problem


def pose_without_dip(problem: LinearProblem, dip_nT: float) -> LinearProblem:
    """A problem of strength and dip posed again without the dip, which is off by an unexplained `dip_nT`."""
    *before, done = problem.corrections
    assert done.field_enu_nT is not None
    strength_nT = float(np.linalg.norm(done.field_enu_nT))
    words = (
        f"{OWN_HEADING}, and the dip is off by {digits(dip_nT)} nT "
        f"({figure(np.degrees(dip_nT / strength_nT), 2)} degrees), "
        "as roll and pitch that err make it: only the field's strength was compared."
    )
    return pose_again(replace(problem, corrections=tuple(before)), problem.recording, None, replace(done, words=words))


def find_misread_field(problem: LinearProblem) -> ReferenceCorrection | None:
    """The reading of the given field that lowers the gap most, if by a large factor; else None.

    Gap: residual of ``R_wb^T F`` with a free matrix and offset, which cannot absorb a dip of the wrong sign in a motion
    with tilt.
    """
    if problem.mode != "vector" or problem.relative:
        return None
    given, used = problem.state.field_enu_nT, problem.usable > 0

    def gap_nT(field_enu_nT: Array) -> float:
        field_nT = to_body(problem.state.R_wb[used], field_enu_nT[None])
        return gap_beside_iron_nT(problem.recording.mag_nT[used], field_nT)

    before_nT = gap_nT(given)
    after_nT, how = min((gap_nT(S @ given), how) for how, S in MISREAD.items())
    read = MISREAD[how] @ given
    if after_nT * problem.policy.far_larger >= before_nT:
        return None
    east, north, up = (f"{value:.0f}" for value in read)
    words = f"The given field is not east, north, up ({how}) and was read anew."
    figures = (
        f"Correct the given field: with ({east}, {north}, {up}) nT the gap falls from {figure(before_nT)} to "
        f"{figure(after_nT)} nT, and the rest was found with it."
    )
    return ReferenceCorrection(words, figures, read)


@dataclass(frozen=True)
class HeadingEvidence:
    """Noise of a sample and calibrated residual in nT, towards magnetic east and in the quieter other direction.

    The other direction is north or along the field: tilt errors act on the first, a noisy sensor axis on the second.
    """

    noise_nT: float
    rms_nT: float
    other_noise_nT: float
    other_rms_nT: float

    def correction(self, field_enu_nT: Array, words: str) -> ReferenceCorrection:
        """The correction in words; `words`: the quantities compared in place of the vector."""
        noise_nT = max(self.noise_nT, LEAST_SHOWN_NT)
        figures = (
            "Log a heading of another instrument: towards magnetic east, where a heading shows, the field has "
            f"{figure(noise_nT)} nT of noise, elsewhere {figure(self.other_noise_nT)} nT. The logged one repeats the "
            "magnetometer's errors, and was left out."
        )
        return ReferenceCorrection(words, figures, field_enu_nT)

    def is_silent(self, policy: Policy) -> bool:
        """Whether east has less noise than the sensor itself, and a smaller gap."""
        quieter = self.noise_nT < policy.compass_noise * self.other_noise_nT
        return quieter and self.rms_nT < policy.half * self.other_rms_nT


def find_own_compass(problem: LinearProblem) -> HeadingEvidence | None:
    """Evidence that navigation's heading was computed from the magnetometer under test; None without evidence.

    ``k . (D m - d) = 0`` for some D and d, ``k = R_wb^T e``, e magnetic east: the definition of a tilt-compensated
    heading with any calibration. D and d are the least right singular vector of the rows of k and m. An independent
    heading has noise of its own, which makes east the noisier direction; a heading computed from m has none. Vector
    mode only, and only where the motion determines D.
    """
    F = problem.state.field_enu_nT
    if problem.mode != "vector" or problem.relative or not np.hypot(*F[:2]):
        return None
    calibration: Array = np.asarray(np.linalg.pinv(problem.turn, rcond=1e-9), dtype=np.float64)
    towards_east = _east_nT(problem, calibration)
    if towards_east is None:
        return None
    parts = np.column_stack([towards_east, *_other_directions_nT(problem, calibration).T])
    noise, size = sample_noise(parts), column_rms(parts)
    found = HeadingEvidence(float(noise[0]), float(size[0]), float(noise[1:].min()), float(size[1:].min()))
    return found if found.is_silent(problem.policy) else None


def _other_directions_nT(problem: LinearProblem, calibration: Array) -> Array:
    """Residual (n, 2) of the base in nT towards magnetic north, and along the field."""
    F, used = problem.state.field_enu_nT, problem.usable > 0
    residual_nT = (problem.recording.mag_nT - problem.clean_nT)[used] @ calibration.T
    level, along = (
        to_body(problem.state.R_wb[used], vector[None] / np.linalg.norm(vector)) for vector in (F * [1, 1, 0], F)
    )
    return np.column_stack([np.einsum("ni,ni->n", level, residual_nT), np.einsum("ni,ni->n", along, residual_nT)])


def _east_nT(problem: LinearProblem, calibration: Array) -> Array | None:
    """``k . (D m - d)`` (n,) in nT for the least-squares D and d, D scaled to the size of a calibration (3, 3)."""
    F, used = problem.state.field_enu_nT, problem.usable > 0
    k = to_body(problem.state.R_wb, np.array([[-F[1], F[0], 0.0]]) / np.hypot(*F[:2]))[used]
    m = problem.recording.mag_nT[used] / np.linalg.norm(F)
    turned = (k[:, :, None] * (m - m.mean(axis=0))[:, None, :]).reshape(len(k), 9)
    rows = np.concatenate([turned, k], axis=1)
    least = np.linalg.eigh(rows.T @ rows)[1][:, 0]
    D = least[:9].reshape(3, 3)
    if np.linalg.cond(D) > problem.policy.much_larger * np.linalg.cond(calibration):
        return None
    return np.asarray(rows @ least * (np.linalg.norm(F) * np.linalg.norm(calibration) / np.linalg.norm(D)))


def gap_beside_iron_nT(mag_nT: Array, field_nT: Array) -> float:
    """Rms in nT of a measured field (n, 3) after a fit of a free matrix and offset to the field (n, 3) in the body."""
    base = np.column_stack([field_nT / 1e4, np.ones(len(field_nT))])
    return rms(mag_nT - base @ np.linalg.lstsq(base.T @ base, base.T @ mag_nT, rcond=1e-13)[0])
