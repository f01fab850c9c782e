"""Checks of the given reference: a field in wrong axes, a heading computed from the magnetometer under test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.formulation import pose_again
from diagnosis.problem.known import Level, ReferenceCorrection
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import sample_noise
from scenarios.arrays import Array
from sim.rotation import to_body
from validation.signals.amplitude import column_rms, rms
from validation.text import digits, figure

OWN_HEADING = "The heading was computed from this very magnetometer"
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
        corrections = (*problem.corrections, misread)
        problem = pose_again(problem, given_enu_nT=misread.field_enu_nT, corrections=corrections)
    if (noises := find_own_compass(problem)) is not None:
        given, bare = problem.state.field_enu_nT, replace(problem.recording, att_q=None)
        level = Level.of(problem.state.R_wb, given, problem.policy, problem.track)
        noise_nT, other_nT = (figure(max(noise, LEAST_SHOWN_NT)) for noise in noises)
        figures = (
            "Log a heading of another instrument: towards magnetic east, where a heading shows, the field has "
            f"{noise_nT} nT of noise, elsewhere {other_nT} nT. The logged one repeats the magnetometer's errors, and "
            "was left out."
        )
        words = f"{OWN_HEADING}: only the field's strength {'was' if level is None else 'and dip were'} compared."
        correction = ReferenceCorrection(words, figures, given)
        problem = pose_again(problem, bare, level=level, corrections=(*problem.corrections, correction))
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
    return pose_again(problem, level=None, corrections=(*before, replace(done, words=words)))


def find_misread_field(problem: LinearProblem) -> ReferenceCorrection | None:
    """The reading of the given field that leaves the least of the gap beside free iron, if by a large factor."""
    if problem.mode != "vector" or problem.relative:
        return None
    given, used = problem.state.field_enu_nT, problem.usable > 0

    def gap_nT(field_enu_nT: Array) -> float:
        field_nT = to_body(problem.state.R_wb[used], field_enu_nT[None])
        return gap_beside_iron_nT(problem.recording.mag_nT[used], field_nT)

    before_nT, (after_nT, how) = gap_nT(given), min((gap_nT(S @ given), how) for how, S in MISREAD.items())
    if after_nT * problem.policy.far_larger >= before_nT:
        return None
    read = MISREAD[how] @ given
    east, north, up = (f"{value:.0f}" for value in read)
    figures = (
        f"Correct the given field: with ({east}, {north}, {up}) nT the gap falls from {figure(before_nT)} to "
        f"{figure(after_nT)} nT, and the rest was found with it."
    )
    return ReferenceCorrection(f"The given field is not east, north, up ({how}) and was read anew.", figures, read)


def find_own_compass(problem: LinearProblem) -> tuple[float, float] | None:
    """Evidence that navigation's heading was computed from the magnetometer under test; None without evidence.

    Noise of a sample in nT towards magnetic east, and in the quieter of the other directions: north, where tilt errors
    act, and along the field, where a noisy sensor axis acts. An independent heading makes east the noisier direction;
    towards east a heading computed from the magnetometer leaves less noise than the sensor has, and less residual.
    """
    F, used = problem.state.field_enu_nT, problem.usable > 0
    if problem.mode != "vector" or problem.relative or not F[:2].any():
        return None
    calibration = problem.ahead_of_iron(np.eye(3)).T
    mag_nT, axes = problem.recording.mag_nT[used], (F[[1, 0, 2]] * [-1, 1, 0], F * [1, 1, 0], F)
    east, *others = (to_body(problem.state.R_wb[used], axis[None] / np.linalg.norm(axis)) for axis in axes)
    east_nT = _own_east_nT(east, mag_nT, float(np.linalg.norm(F)), calibration, problem.policy)
    if east_nT is None:
        return None
    field_nT = problem.ahead_of_iron(problem.off_nT)[used]
    parts = np.column_stack([east_nT, *((other * field_nT).sum(axis=1) for other in others)])
    (noise, *noises), (size, *sizes) = sample_noise(parts).tolist(), column_rms(parts).tolist()
    silent = noise < problem.policy.compass_noise * min(noises) and size < problem.policy.half * min(sizes)
    return (noise, min(noises)) if silent else None


def _own_east_nT(k: Array, mag_nT: Array, strength_nT: float, calibration: Array, policy: Policy) -> Array | None:
    """``k . (D m - d)`` (n,) in nT for the D and d that make k . (D m - d) least, k (n, 3) towards magnetic east.

    ``k . (D m - d) = 0`` defines a tilt-compensated heading with any calibration. D is scaled to a calibration (3, 3);
    None where D is far worse conditioned.
    """
    m = mag_nT / strength_nT
    turned = (k[:, :, None] * (m - m.mean(axis=0))[:, None, :]).reshape(len(k), 9)
    rows = np.concatenate([turned, k], axis=1)
    least = np.linalg.eigh(rows.T @ rows)[1][:, 0]
    D = least[:9].reshape(3, 3)
    if np.linalg.cond(D) > policy.much_larger * np.linalg.cond(calibration):
        return None
    return np.asarray(rows @ least * (strength_nT * np.linalg.norm(calibration) / np.linalg.norm(D)))


def gap_beside_iron_nT(mag_nT: Array, field_nT: Array) -> float:
    """Rms in nT of a measured field (n, 3) after a fit of a free matrix and offset to the field (n, 3) in the body."""
    base = np.column_stack([field_nT / 1e4, np.ones(len(field_nT))])
    return rms(mag_nT - base @ np.linalg.lstsq(base.T @ base, base.T @ mag_nT, rcond=1e-13)[0])
