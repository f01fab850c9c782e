"""What is said before a verdict: a reference that was mended, a long track, iron that the strength contradicts."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from diagnosis.evidence.baseline import Baseline
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import turn_rate_rad_s, turns_too_fast
from diagnosis.result import Diagnosis, How
from diagnosis.verdict import Verdict
from recordings.channels import ALTITUDE
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.chain_position import iron_matrix
from validation.signals.amplitude import rms
from validation.signals.time_units import finer_unit
from validation.text import digits

EARTH_RADIUS_M = 6.371e6
"""Of the sphere; a dipole's field falls with the third power of the distance from its centre."""

AXES = [
    np.array(order) * np.array(signs)[:, None]
    for order in itertools.permutations(np.eye(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
]
"""The 48 matrices that carry axes to axes: 24 turns, and as many that mirror."""


def remarks(found: Diagnosis) -> tuple[str, ...]:
    """Sentences that go before the verdict's own: every line of `REMARKS` that applies."""
    return tuple(line for remark in REMARKS for line in remark(found))


def mended(found: Diagnosis) -> Iterator[str]:
    """What was done about a reference that was wrong."""
    yield from (one.words for one in found.problem.instead)


def long_track(found: Diagnosis) -> Iterator[str]:
    """A track along which the Earth's own field changes as much as a fair share of the gap, beside one given vector."""
    problem, policy, gap = found.problem, found.problem.policy, found.gap
    if problem.track is not None or "position" not in problem.has or found.verdict is Verdict.NONE:
        return
    length_m = float(np.hypot(*np.ptp(problem.state.pos_enu_m, axis=0)[:2]))
    change_nT = policy.earth_gradient_nT_m * length_m
    if change_nT > max(policy.least_share * gap.structure_nT[0], gap.noise_nT):
        yield (
            f"The path is {digits(length_m / 1e3)} km long: over it the Earth's own field changes by some "
            f"{digits(change_nT)} nT, and one vector was given for all of it."
        )


def long_climb(found: Diagnosis) -> Iterator[str]:
    """Heights between which the Earth's own field changes as much, as that of a dipole does: ``3 F h / R``."""
    problem, policy, gap = found.problem, found.problem.policy, found.gap
    if problem.track is not None or problem.relative or problem.still or found.verdict is Verdict.NONE:
        return
    climb_m = _climb_m(problem)
    change_nT = 3 * float(np.linalg.norm(problem.state.field_enu_nT)) * climb_m / EARTH_RADIUS_M
    if change_nT > max(policy.least_share * gap.structure_nT[0], gap.noise_nT):
        yield (
            f"The log goes over {digits(climb_m / 1e3)} km of height: over it the Earth's own field changes by some "
            f"{digits(change_nT)} nT, and one field was given for all of it."
        )


def _climb_m(problem: LinearProblem) -> float:
    """Between the lowest and the highest of the recorded altitudes, or of the positions."""
    altitude_m = problem.recording.channels.get(ALTITUDE)
    if altitude_m is None:
        return float(np.ptp(problem.state.pos_enu_m[:, 2])) if "position" in problem.has else 0.0
    known = altitude_m[np.isfinite(altitude_m)]
    return float(np.ptp(known)) if known.size else 0.0


def another_scale(found: Diagnosis) -> Iterator[str]:
    """Iron of the model that gives another strength than the stated one, where the strength alone is compared."""
    if (other := other_strength(found.problem)) is not None:
        yield (
            f"By the model's own iron the field is {digits(other.scale, 4)} times the stated strength, which leaves "
            f"{digits(other.given_nT)} nT, as iron fitted anew does not: the strength is wrong, or the sensor's scale. "
            "Beside iron fitted anew:"
        )


def other_iron(found: Diagnosis) -> Iterator[str]:
    """Iron of the model that does not fit, or that it does not have, where no name says so."""
    told = any(one.how is How.IRON for one in found.named) or other_strength(found.problem) is not None
    if told or not found.problem.iron_known:
        return
    given_nT, anew_nT = left_by_iron_nT(found.problem)
    if given_nT > found.problem.policy.unfit_iron * anew_nT:
        yield (
            f"The model as it stands leaves {digits(given_nT)} nT, and with hard and soft iron fitted anew "
            f"{digits(anew_nT)} nT: its iron is another. Calibrate again. Beside iron fitted anew:"
        )


def left_by_iron_nT(problem: LinearProblem) -> tuple[float, float]:
    """Rms (nT) that the model's iron leaves of what was compared, and that fitted iron leaves."""
    used = problem.usable > 0
    if problem.mode == "vector":
        given = (problem.recording.mag_nT - problem.predicted_nT)[used]
        anew = Baseline.of(problem).residual()[used] * problem.sigma_nT
        return rms(given), rms(anew)
    F = np.linalg.norm(problem.state.field_nT, axis=1)[used]
    return rms(_by_model_nT(problem)[used] - F), rms(_anew_nT(problem)[used] - F)


def turned_axes(found: Diagnosis) -> Iterator[str]:
    """Axes of the magnetometer that are others of the body's, and of which the model knows not."""
    if (axes := other_axes(found.problem)) is not None:
        yield (
            f"The magnetometer's x, y, z lie along the body's {axes}: give the field in the axes of the attitude, by "
            "--map with scale=-1 for an axis that points the other way."
        )


def other_axes(problem: LinearProblem) -> str | None:
    """The body's axes that a magnetometer's x, y, z lie along, where they are others than the model's, in words.

    The matrix nearest to one of `AXES` is that which carries the modelled field best to the measured one [Wahba1965]:
    ``U V``, where ``U diag(s) V`` is the mean of their products, each about its mean [Markley1988]. It may mirror only
    where the motion shows three axes: one that it does not show is a right-handed sensor's.
    """
    if not problem.turns:
        return None
    measured_nT, modelled_nT = (one - one.mean(axis=0) for one in (problem.clean_nT, problem.predicted_nT))
    U, s, V = np.linalg.svd(measured_nT.T @ modelled_nT / len(measured_nT))
    shown = int(np.count_nonzero(np.sqrt(s) > _least_shown_nT(problem)))
    if shown < 3:
        U[:, 2] *= np.linalg.det(U @ V)
    nearest = max(AXES, key=lambda P: float((P * (U @ V)).sum()))
    off_deg = np.degrees(np.arccos(np.clip(((nearest * (U @ V)).sum() - 1) / 2, -1.0, 1.0)))
    if shown < 2 or np.allclose(nearest, np.eye(3)) or off_deg > problem.policy.turned_axes_deg:
        return None
    return ", ".join(map(_axis, nearest)) + _as_shown(nearest, shown)


def _axis(row: Array) -> str:
    return f"{'-' if row.sum() < 0 else ''}{'xyz'[int(np.abs(row).argmax())]}"


def _least_shown_nT(problem: LinearProblem) -> float:
    """Spread of the field along a direction from which on its sign is known: it is more than what no iron explains."""
    left_nT = (problem.target * problem.sigma_nT)[problem.usable > 0]
    return max(problem.policy.shown_axis * float(np.linalg.norm(problem.state.field_enu_nT)), rms(left_nT))


def _as_shown(axes: Array, shown: int) -> str:
    """What else is said of axes (3, 3), by how many directions of the field the motion shows."""
    if shown < 3:
        return " (or mirrored, or the attitude turns the other way: this motion does not tell)"
    return ", mirrored (the sign of a column is wrong, or their order)" if np.linalg.det(axes) < 0 else ""


def turned_mount(found: Diagnosis) -> Iterator[str]:
    """A change of the iron that is the attitude's: its axes are turned against those of the model's iron."""
    iron = [one.effect for one in found.named if one.how is How.IRON]
    matrix = any(one.traits.absorbed and not one.traits.constant and not one.tangents for one in iron)
    if matrix and (turn_deg := turn_of_the_mount(found.problem)) is not None:
        angles = ", ".join(digits(one) for one in turn_deg)
        yield (
            f"But for a small part the iron differs from the model's by a turn of {digits(rms(turn_deg) * 3**0.5)} "
            f"degrees ({angles} about forward, left, up) between the attitude's axes and the magnetometer's: check how "
            "both are mounted before iron is sought."
        )


def turn_of_the_mount(problem: LinearProblem) -> Array | None:
    """Rotation vector (3,) in degrees that carries the field of the attitude's axes to that which the iron met.

    ``A^-1 M``, A the model's matrix and M the fitted one, is a turn R where M = A R. None where it is not.
    """
    if not (problem.turns and problem.iron_known):
        return None
    T = np.linalg.solve(iron_matrix(problem.effects, problem.state), problem.turn)
    U, _, V = np.linalg.svd(T)
    R = U @ V
    differs, left = (((T - one) ** 2).sum() for one in (np.eye(3), R))
    if np.linalg.det(R) < 0 or left > (1 - problem.policy.mount_share) * differs:
        return None
    return np.asarray(Rotation.from_matrix(R).as_rotvec(degrees=True))


def finer_stamps(found: Diagnosis) -> Iterator[str]:
    """Time stamps that look like milliseconds, or finer."""
    given = found.problem.recording
    if (finer := finer_unit(given.time_s, given.mag_nT, given.gyro_rad_s, given.att_q)) is not None:
        yield finer.words("COLUMN")


def too_fast(found: Diagnosis) -> Iterator[str]:
    """A field that turns faster than any vehicle: the sensor may not turn at all."""
    if turns_too_fast(found.problem):
        yield (
            f"The field turns at {digits(turn_rate_rad_s(found.problem))} rad/s in the median, faster than a vehicle "
            "does: a magnet that turns beside a sensor at rest looks so. Log attitude or a gyro."
        )


@dataclass(frozen=True)
class OtherStrength:
    """By what factor the strength differs from the stated one with the model's iron, and what that leaves in nT."""

    scale: float
    given_nT: float


def other_strength(problem: LinearProblem) -> OtherStrength | None:
    """Where the strength alone is compared and the model's iron is known: whether a factor is what that differs by.

    Of the strength the model's iron leaves more than iron fitted anew, and a factor alone takes nearly all of that up.
    The model's iron is matrix A and offset b of what it predicts along the measured motion, ``A f + b``.
    """
    if problem.mode != "strength" or not problem.iron_known:
        return None
    policy, used = problem.policy, problem.usable > 0
    F = np.linalg.norm(problem.state.field_nT, axis=1)[used]
    by_model, anew = (one[used] for one in (_by_model_nT(problem), _anew_nT(problem)))
    scale = float(by_model @ F / (F @ F))
    given, scaled, best = (
        float(((one - F * k) ** 2).mean()) for one, k in ((by_model, 1), (by_model, scale), (anew, 1))
    )
    differs = given > policy.other_iron**2 * best and given - scaled > policy.scale_share * (given - best)
    return OtherStrength(scale, given**0.5) if differs else None


def _by_model_nT(problem: LinearProblem) -> Array:
    """``|A^-1 (m - b)|`` (n,) by the model's own iron."""
    predicted_nT = apply_deterministic(problem.effects, problem.state)[0]
    design = np.column_stack([problem.state.field_nT, np.ones(len(predicted_nT))])
    both = np.linalg.lstsq(design, predicted_nT, rcond=1e-9)[0]
    return np.asarray(np.linalg.norm((problem.recording.mag_nT - both[3]) @ np.linalg.pinv(both[:3]), axis=1))


def _anew_nT(problem: LinearProblem) -> Array:
    """The same by the iron that was fitted."""
    offset_nT = problem.clean_nT[0] - problem.turn @ problem.state.field_nT[0]
    return np.asarray(np.linalg.norm((problem.recording.mag_nT - offset_nT) @ np.linalg.pinv(problem.turn).T, axis=1))


REMARKS: tuple[Callable[[Diagnosis], Iterator[str]], ...] = (
    mended,
    long_track,
    long_climb,
    finer_stamps,
    turned_axes,
    turned_mount,
    too_fast,
    another_scale,
    other_iron,
)
