"""Is the reference itself wrong? A field with the wrong sign of its dip, a heading made from this magnetometer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.formulation import posed_anew
from diagnosis.problem.level import Level
from diagnosis.problem.linear import Instead, LinearProblem, sample_noise
from scenarios.arrays import Array
from sim.rotation import to_body
from validation.signals.amplitude import column_rms, rms
from validation.text import digits

OWN_HEADING = "The heading was computed from this very magnetometer"
COMPASS = f"{OWN_HEADING}: only the field's strength and dip were compared."
STEEP = f"{OWN_HEADING}: only the field's strength was compared."
LEAST_SHOWN_NT = 0.01
"""Noise below which a heading is of no other instrument for certain, nT."""
MISREAD = {
    "its vertical part has the other sign": np.diag([1.0, 1.0, -1.0]),
    "it is north, east, down": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
}
"""What may have been given in place of east, north, up: in words, and the matrix (3, 3) that makes it right."""


def settled(problem: LinearProblem) -> LinearProblem:
    """The problem as it is, or posed anew where its reference is wrong, with what was done in `instead`.

    A field that was misread is read right. A heading that was made from this magnetometer is left out: of the attitude
    roll and pitch stay, which tell where down is, so that the field's strength and dip are compared.
    """
    if (misread := misread_field(problem)) is not None:
        problem = posed_anew(problem, problem.recording, misread.field_enu_nT, misread.instead)
    if (east := own_compass(problem)) is not None:
        given, bare = problem.state.field_enu_nT, replace(problem.recording, att_q=None)
        level = Level.of(problem.state.R_wb, given, problem.policy)
        problem = posed_anew(problem, bare, None, east.instead(given, STEEP if level is None else COMPASS), level)
    return problem


def by_strength_alone(problem: LinearProblem, dip_nT: float) -> LinearProblem:
    """A problem of strength and dip posed anew without the dip, which is off by so much in a way that has no name."""
    *before, done = problem.instead
    strength_nT = float(np.linalg.norm(done.field_enu_nT))
    words = (
        f"{OWN_HEADING}, and the dip is off by {digits(dip_nT)} nT ({np.degrees(dip_nT / strength_nT):.2g} degrees), "
        "as roll and pitch that err make it: only the field's strength was compared."
    )
    return posed_anew(replace(problem, instead=tuple(before)), problem.recording, None, replace(done, words=words))


@dataclass(frozen=True)
class Misread:
    """A given field read in another way: how, the field (3,) then, and the gap before and after in nT."""

    how: str
    field_enu_nT: Array
    before_nT: float
    after_nT: float

    @property
    def instead(self) -> Instead:
        """What is said of it."""
        east, north, up = (f"{value:.0f}" for value in self.field_enu_nT)
        words = f"The given field is not east, north, up ({self.how}) and was read anew."
        figures = (
            f"Correct the given field: with ({east}, {north}, {up}) nT the gap falls from {self.before_nT:.3g} to "
            f"{self.after_nT:.3g} nT, and the rest was found with it."
        )
        return Instead(words, figures, self.field_enu_nT)


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


@dataclass(frozen=True)
class East:
    """Noise of a sample and rms (nT) of what a calibration leaves: towards magnetic east, and beside it.

    Beside it is the quieter of north and along the field: tilt shows in the one, a noisy axis of the sensor in the
    other.
    """

    noise_nT: float
    rms_nT: float
    beside_noise_nT: float
    beside_rms_nT: float

    def instead(self, field_enu_nT: Array, words: str) -> Instead:
        """What is said of it, after what was compared in words."""
        noise_nT = max(self.noise_nT, LEAST_SHOWN_NT)
        figures = (
            "Log a heading of another instrument: towards magnetic east, where a heading shows, the field has "
            f"{noise_nT:.3g} nT of noise, elsewhere {self.beside_noise_nT:.3g} nT. The logged one repeats the "
            "magnetometer's errors, and was left out."
        )
        return Instead(words, figures, field_enu_nT)

    def is_silent(self, policy: Policy) -> bool:
        """Whether east has less noise than the sensor itself, and less of a gap."""
        quieter = self.noise_nT < policy.compass_noise * self.beside_noise_nT
        return quieter and self.rms_nT < policy.compass_gap * self.beside_rms_nT


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
    parts = np.column_stack([towards_east, *_beside_nT(problem, calibration).T])
    noise, size = sample_noise(parts), column_rms(parts)
    found = East(float(noise[0]), float(size[0]), float(noise[1:].min()), float(size[1:].min()))
    return found if found.is_silent(problem.policy) else None


def _beside_nT(problem: LinearProblem, calibration: Array) -> Array:
    """What the base leaves (n, 2) in nT towards magnetic north, and along the field."""
    F, used = problem.state.field_enu_nT, problem.usable > 0
    left = (problem.recording.mag_nT - problem.clean_nT)[used] @ calibration.T
    level, along = (to_body(problem.state.R_wb[used], one[None] / np.linalg.norm(one)) for one in (F * [1, 1, 0], F))
    return np.column_stack([np.einsum("ni,ni->n", level, left), np.einsum("ni,ni->n", along, left)])


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
