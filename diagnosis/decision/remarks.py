"""Remarks placed before the verdict: a corrected reference, a long track, iron contradicting the field's strength."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import turn_rate_rad_s, turns_too_fast
from diagnosis.result import Diagnosis, EvidenceKind
from diagnosis.verdict import Verdict
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from recordings.readers.navigation import EARTH_RADIUS_M
from sim.chain import apply_deterministic
from sim.effects.chain_position import iron_matrix
from validation.axes.maps import TURNS, is_turn, map_text
from validation.signals.amplitude import rms
from validation.signals.time_units import finer_unit
from validation.text import digits


def remarks(diagnosis: Diagnosis) -> Iterator[str]:
    """Sentences before the verdict: what is wrong with reference, time stamps, axes and mount, and with the iron."""
    yield from (words for words, _ in reference_remarks(diagnosis))
    problem, given = diagnosis.problem, diagnosis.problem.recording
    if (finer := finer_unit(given.time_s, given.mag_nT, given.gyro_rad_s, given.att_q)) is not None:
        yield finer.words("COLUMN")
    if (axes := axis_permutation(problem)) is not None:
        yield (
            f"The magnetometer's x, y, z lie along the body's {axes}: map the field to the axes of the attitude with "
            "--map, scale=-1 for a reversed axis."
        )
    yield from mount_remark(diagnosis)
    if turns_too_fast(problem):
        yield (
            f"The field turns at {digits(turn_rate_rad_s(problem))} rad/s in the median, faster than a vehicle can: a "
            "magnet turning near a sensor at rest looks the same. Log attitude or a gyro."
        )
    yield from iron_remark(diagnosis)


def reference_remarks(diagnosis: Diagnosis) -> Iterator[tuple[str, str]]:
    """Words and advice for each correction of the reference, and for a field that changes along the path.

    A single field is given, while the Earth's changes by a fair share of the gap: along the track by its gradient, over
    a range of heights h as a dipole's, by ``3 F h / R``.
    """
    problem, gap = diagnosis.problem, diagnosis.gap
    yield from ((correction.words, correction.figures) for correction in problem.corrections)
    if problem.track is not None or diagnosis.verdict is Verdict.NONE:
        return
    least_nT = max(problem.policy.fair_share * gap.structure_nT[0], gap.noise_nT)
    pos_enu_m = problem.state.pos_enu_m if "position" in problem.inputs else np.zeros((1, 3))
    length_m = float(np.hypot(*np.ptp(pos_enu_m, axis=0)[:2]))
    if (along_nT := problem.policy.earth_gradient_nT_m * length_m) > least_nT:
        yield (
            f"The path is {digits(length_m / 1e3)} km long; along it the Earth's field changes by about "
            f"{digits(along_nT)} nT, but a single field vector was given.",
            f"Add the position of the log, --map {LATITUDE}=COLUMN --map {LONGITUDE}=COLUMN: the model's field then "
            "follows IGRF along the track. Without a position, a named gradient may be the Earth's own.",
        )
    altitude_m = problem.recording.channels.get(ALTITUDE, pos_enu_m[:, 2])
    known_m = altitude_m[np.isfinite(altitude_m)]
    climb_m = 0.0 if problem.relative or problem.still or not known_m.size else float(np.ptp(known_m))
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    if (over_nT := 3 * strength_nT * climb_m / EARTH_RADIUS_M) > least_nT:
        yield (
            f"The log spans {digits(climb_m / 1e3)} km of height; over this range the Earth's field changes by about "
            f"{digits(over_nT)} nT, but a single field was given.",
            f"State the model's [field] by {LATITUDE}, {LONGITUDE} and date, and add the height of the log, "
            f"--map {ALTITUDE}=COLUMN: the model's field then follows IGRF with height. Without a height, an effect "
            "rising or falling with height may be the Earth's own change.",
        )


def iron_remark(diagnosis: Diagnosis) -> Iterator[str]:
    """Iron of the model that does not fit beside the named effects, or that gives another strength than stated."""
    problem, factor = diagnosis.problem, None
    if diagnosis.of_kind(EvidenceKind.IRON) or not problem.iron_known:
        return
    if problem.mode == "vector":
        smooth = [effect for effect in diagnosis.model.chain() if not effect.traits.converter]
        left_nT = problem.recording.mag_nT - apply_deterministic(smooth, problem.state)[0]
        given_nT, anew_nT = (rms(residual_nT[problem.usable > 0]) for residual_nT in (left_nT, diagnosis.after_nT))
    else:
        given_nT, anew_nT, factor = strength_residuals_nT(problem)
    if factor is not None:
        yield (
            f"With the model's iron the field is {digits(factor, 4)} times the stated strength, which leaves "
            f"{digits(given_nT)} nT unexplained; refitted iron explains it. Either the strength or the sensor's "
            "scale is wrong. With refitted iron:"
        )
    elif given_nT > problem.policy.clearly_larger * anew_nT:
        yield (
            f"The model leaves {digits(given_nT)} nT unexplained, but {digits(anew_nT)} nT with refitted hard and soft "
            "iron: the iron has changed. Calibrate again. With refitted iron:"
        )


def strength_residuals_nT(problem: LinearProblem) -> tuple[float, float, float | None]:
    """Rms (nT) of the strength by the model's iron, and by fitted iron, minus the stated one; and a factor.

    The factor is the ratio of the strength by the model's iron, ``|A^-1 (m - b)|``, to the stated one, if the model's
    iron leaves more than fitted iron and the factor alone explains nearly all of it; else None. A and b follow from the
    prediction along the measured motion, ``A f + b``.
    """
    predicted_nT, field_nT = apply_deterministic(problem.effects, problem.state)[0], problem.state.field_nT
    both = np.linalg.lstsq(np.column_stack([field_nT, np.ones(len(field_nT))]), predicted_nT, rcond=1e-9)[0]
    by_model_nT = (problem.recording.mag_nT - both[3]) @ np.linalg.pinv(both[:3])
    earth_nT = problem.recording.mag_nT - problem.beyond_nT - problem.offset_nT
    several_nT = (by_model_nT, earth_nT @ np.linalg.pinv(problem.turn).T, field_nT)
    by_model, anew, F = (np.linalg.norm(each_nT, axis=1)[problem.usable > 0] for each_nT in several_nT)
    policy, factor = problem.policy, float(by_model @ F / (F @ F))
    given, scaled, best = (rms(left) for left in (by_model - F, by_model - factor * F, anew - F))
    is_factor = given > policy.larger * best and given**2 - scaled**2 > policy.nearly_all * (given**2 - best**2)
    return given, best, factor if is_factor else None


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
    least_nT = max(problem.policy.hardly_any * float(np.linalg.norm(problem.state.field_enu_nT)), left_nT)
    visible = int(np.count_nonzero(np.sqrt(s) > least_nT))
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
    """A change of the iron by rotated axes of the attitude: ``M = A R``, A the model's matrix and M the fitted one."""
    problem, iron = diagnosis.problem, [cause.effect for cause in diagnosis.of_kind(EvidenceKind.IRON)]
    matrix = any(one.traits.absorbed and not (one.traits.constant or one.tangents) for one in iron)
    if not (matrix and problem.turns):
        return
    T = np.linalg.solve(iron_matrix(problem.effects, problem.state), problem.turn)
    U, _, V = np.linalg.svd(T)
    R = U @ V
    differs, left = (((T - reference) ** 2).sum() for reference in (np.eye(3), R))
    if np.linalg.det(R) > 0 and left <= (1 - problem.policy.mount_share) * differs:
        turn_deg = Rotation.from_matrix(R).as_rotvec(degrees=True)
        yield (
            f"Nearly all of the change of iron is a rotation by {digits(float(np.linalg.norm(turn_deg)))} degrees "
            f"({', '.join(map(digits, turn_deg))} about forward, left, up) between the attitude's axes and the "
            "magnetometer's: check how both are mounted before looking for iron."
        )
