"""Remarks placed before the verdict: a corrected reference, a long track, iron contradicting the field's strength."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import turn_rate_rad_s, turns_too_fast
from diagnosis.result import Diagnosis, EvidenceKind
from diagnosis.verdict import Verdict
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from recordings.readers.navigation import EARTH_RADIUS_M
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.chain_position import iron_matrix
from validation.axes.maps import TURNS, is_turn, map_text
from validation.signals.amplitude import rms
from validation.signals.time_units import finer_unit
from validation.text import digits


def remarks(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Sentences before the verdict: what is wrong with the reference, and all applicable lines of `REMARKS`."""
    of_reference = (words for words, _ in reference_remarks(diagnosis))
    return (*of_reference, *(line for remark in REMARKS for line in remark(diagnosis)))


def reference_remarks(diagnosis: Diagnosis) -> Iterator[tuple[str, str]]:
    """Words and advice for each correction of the reference, and for a field that changes along the path."""
    yield from ((correction.words, correction.figures) for correction in diagnosis.problem.corrections)
    if diagnosis.problem.track is None and diagnosis.verdict is not Verdict.NONE:
        yield from long_track(diagnosis)
        yield from long_climb(diagnosis)


def long_track(diagnosis: Diagnosis) -> Iterator[tuple[str, str]]:
    """A track along which the Earth's field changes by a fair share of the gap, while a single vector was given."""
    problem = diagnosis.problem
    if "position" in problem.inputs:
        length_m = float(np.hypot(*np.ptp(problem.state.pos_enu_m, axis=0)[:2]))
        if change := _change(diagnosis, problem.policy.earth_gradient_nT_m * length_m):
            yield (
                f"The path is {digits(length_m / 1e3)} km long; along it {change}, but a single field vector was "
                "given.",
                f"Add the position of the log, --map {LATITUDE}=COLUMN --map {LONGITUDE}=COLUMN: the model's field "
                "then follows IGRF along the track. Without a position, a named gradient may be the Earth's own.",
            )


def long_climb(diagnosis: Diagnosis) -> Iterator[tuple[str, str]]:
    """A range of heights over which the Earth's dipole field changes, by ``3 F h / R``, a fair share of the gap."""
    problem = diagnosis.problem
    if not (problem.relative or problem.still):
        climb_m = _climb_m(problem)
        strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
        if change := _change(diagnosis, 3 * strength_nT * climb_m / EARTH_RADIUS_M):
            yield (
                f"The log spans {digits(climb_m / 1e3)} km of height; over this range {change}, but a single field was "
                "given.",
                f"State the model's [field] by {LATITUDE}, {LONGITUDE} and date, and add the height of the log, "
                f"--map {ALTITUDE}=COLUMN: the model's field then follows IGRF with height. Without a height, an "
                "effect rising or falling with height may be the Earth's own change.",
            )


def _change(diagnosis: Diagnosis, change_nT: float) -> str:
    """A change of the Earth's field in words; empty where neither a fair share of the gap nor above the noise."""
    gap, least = diagnosis.gap, diagnosis.problem.policy.fair_share * diagnosis.gap.structure_nT[0]
    large = change_nT > max(least, gap.noise_nT)
    return f"the Earth's field changes by about {digits(change_nT)} nT" if large else ""


def _climb_m(problem: LinearProblem) -> float:
    """Range of the recorded altitudes, or of the positions."""
    altitude_m = problem.recording.channels.get(ALTITUDE)
    if altitude_m is None:
        return float(np.ptp(problem.state.pos_enu_m[:, 2])) if "position" in problem.inputs else 0.0
    known = altitude_m[np.isfinite(altitude_m)]
    return float(np.ptp(known)) if known.size else 0.0


def iron_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """Model iron that does not fit, without being named, or that gives another strength than stated."""
    problem = diagnosis.problem
    if any(cause.kind is EvidenceKind.IRON for cause in diagnosis.named) or not problem.iron_known:
        return
    if (mismatch := strength_mismatch(problem)) is not None:
        yield (
            f"With the model's iron the field is {digits(mismatch.scale, 4)} times the stated strength, which leaves "
            f"{digits(mismatch.given_nT)} nT unexplained; refitted iron explains it. Either the strength or the "
            "sensor's scale is wrong. With refitted iron:"
        )
        return
    given_nT, anew_nT = iron_residuals_nT(diagnosis)
    if given_nT > problem.policy.clearly_larger * anew_nT:
        yield (
            f"The model leaves {digits(given_nT)} nT unexplained, but {digits(anew_nT)} nT with refitted hard and soft "
            "iron: the iron has changed. Calibrate again. With refitted iron:"
        )


def iron_residuals_nT(diagnosis: Diagnosis) -> tuple[float, float]:
    """Rms (nT) of the compared quantities after the model's iron, and after fitted iron.

    Named effects are subtracted in vector mode: a motor's mean field is no iron.
    """
    problem = diagnosis.problem
    if problem.mode == "vector":
        smooth = [effect for effect in diagnosis.model.chain() if not effect.traits.converter]
        given_nT = problem.recording.mag_nT - apply_deterministic(smooth, problem.state)[0]
        used = problem.usable > 0
        return rms(given_nT[used]), rms(diagnosis.after_nT[used])
    by_model, anew, F = _strengths_nT(problem)
    return rms(by_model - F), rms(anew - F)


def axes_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """Magnetometer axes permuted against the body axes, unknown to the model."""
    if (axes := axis_permutation(diagnosis.problem)) is not None:
        yield (
            f"The magnetometer's x, y, z lie along the body's {axes}: map the field to the axes of the attitude with "
            "--map, scale=-1 for a reversed axis."
        )


def axis_permutation(problem: LinearProblem) -> str | None:
    """The body axes along which the magnetometer's x, y, z lie, in words, where they differ from the model's.

    The permutation nearest to the matrix that best maps the modelled to the measured field [Wahba1965]: ``U V``, where
    ``U diag(s) V`` is the mean product of both fields about their means [Markley1988]. Reflections are considered only
    where the motion shows three axes, by a spread of the field above the residual of any iron; an unseen axis is taken
    as right-handed.
    """
    if not problem.turns:
        return None
    measured_nT, modelled_nT = (
        field_nT - field_nT.mean(axis=0) for field_nT in (problem.clean_nT, problem.predicted_nT)
    )
    U, s, V = np.linalg.svd(measured_nT.T @ modelled_nT / len(measured_nT))
    left_nT = rms((problem.target * problem.sigma_nT)[problem.usable > 0])
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    visible = int(np.count_nonzero(np.sqrt(s) > max(problem.policy.hardly_any * strength_nT, left_nT)))
    if visible < 3:
        U[:, 2] *= np.linalg.det(U @ V)
    nearest = max([*TURNS, *-TURNS], key=lambda P: float((P * (U @ V)).sum()))
    off_deg = np.degrees(np.arccos(np.clip(((nearest * (U @ V)).sum() - 1) / 2, -1.0, 1.0)))
    if visible < 2 or np.allclose(nearest, np.eye(3)) or off_deg > problem.policy.turned_axes_deg:
        return None
    told = map_text(nearest).replace(",", ", ")
    if visible < 3:
        return f"{told} (or mirrored, or the attitude is inverted: cannot be determined on this motion)"
    return told if is_turn(nearest) else f"{told}, mirrored (the sign or the order of columns is wrong)"


def mount_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """A change of the iron due to the attitude's axes being rotated against those of the model's iron."""
    iron = [effect.effect for effect in diagnosis.named if effect.kind is EvidenceKind.IRON]
    matrix = any(effect.traits.absorbed and not effect.traits.constant and not effect.tangents for effect in iron)
    if matrix and (turn_deg := mount_rotation_deg(diagnosis.problem)) is not None:
        angles = ", ".join(digits(effect) for effect in turn_deg)
        yield (
            f"Nearly all of the change of iron is a rotation by {digits(rms(turn_deg) * 3**0.5)} "
            f"degrees ({angles} about forward, left, up) between the attitude's axes and the magnetometer's: check how "
            "both are mounted before looking for iron."
        )


def mount_rotation_deg(problem: LinearProblem) -> Array | None:
    """Rotation vector (3,) in degrees from the attitude's axes to those of the model's iron.

    ``A^-1 M``, A the model's matrix and M the fitted one, is a rotation R where M = A R; None elsewhere.
    """
    if not (problem.turns and problem.iron_known):
        return None
    T = np.linalg.solve(iron_matrix(problem.effects, problem.state), problem.turn)
    U, _, V = np.linalg.svd(T)
    R = U @ V
    differs, left = (((T - reference) ** 2).sum() for reference in (np.eye(3), R))
    if np.linalg.det(R) < 0 or left > (1 - problem.policy.mount_share) * differs:
        return None
    return np.asarray(Rotation.from_matrix(R).as_rotvec(degrees=True))


def time_unit_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """Time stamps resembling milliseconds, or finer."""
    given = diagnosis.problem.recording
    if (finer := finer_unit(given.time_s, given.mag_nT, given.gyro_rad_s, given.att_q)) is not None:
        yield finer.words("COLUMN")


def rotation_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """A field turning faster than any vehicle: the sensor may be at rest."""
    if turns_too_fast(diagnosis.problem):
        yield (
            f"The field turns at {digits(turn_rate_rad_s(diagnosis.problem))} rad/s in the median, faster than a "
            "vehicle can: a magnet turning near a sensor at rest looks the same. Log attitude or a gyro."
        )


@dataclass(frozen=True)
class StrengthMismatch:
    """Ratio of the strength by the model's iron to the stated one, and the residual in nT."""

    scale: float
    given_nT: float


def strength_mismatch(problem: LinearProblem) -> StrengthMismatch | None:
    """The mismatch of strength where the strength alone is compared and the model's iron is known; None if none.

    The model's iron leaves more of the strength than refitted iron, and a factor alone explains nearly all of it.
    Matrix A and offset b of the model's iron follow from the prediction along the measured motion, ``A f + b``.
    """
    if problem.mode != "strength" or not problem.iron_known:
        return None
    policy, (by_model, anew, F) = problem.policy, _strengths_nT(problem)
    scale = float(by_model @ F / (F @ F))
    given, scaled, best = (rms(left) ** 2 for left in (by_model - F, by_model - scale * F, anew - F))
    differs = given > policy.larger**2 * best and given - scaled > policy.nearly_all * (given - best)
    return StrengthMismatch(scale, given**0.5) if differs else None


def _strengths_nT(problem: LinearProblem) -> tuple[Array, Array, Array]:
    """``|A^-1 (m - b)|`` (m,) by the model's iron and by the fitted iron, and the field's strength, of used samples."""
    predicted_nT, used = apply_deterministic(problem.effects, problem.state)[0], problem.usable > 0
    design = np.column_stack([problem.state.field_nT, np.ones(len(predicted_nT))])
    both = np.linalg.lstsq(design, predicted_nT, rcond=1e-9)[0]
    by_model_nT = (problem.recording.mag_nT - both[3]) @ np.linalg.pinv(both[:3])
    earth_nT = problem.recording.mag_nT - problem.beyond_nT - problem.offset_nT
    several_nT = (by_model_nT, earth_nT @ np.linalg.pinv(problem.turn).T, problem.state.field_nT)
    by_model, anew, F = (np.linalg.norm(each_nT, axis=1)[used] for each_nT in several_nT)
    return by_model, anew, F


REMARKS: tuple[Callable[[Diagnosis], Iterator[str]], ...] = (
    time_unit_remark,
    axes_remark,
    mount_remark,
    rotation_remark,
    iron_remark,
)
