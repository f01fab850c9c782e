"""A diagnosis as series to draw and record: both sides, thinned by block means, and the gap along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, How
from scenarios.arrays import Array
from sim.chain import apply_deterministic

MOST_BLOCKS, BLOCK_S = 4000, 1.0
"""Of the gap along the path: points at most, and the shortest time that one is the mean of."""


@dataclass(frozen=True)
class ComparedSeries:
    """Measured and simulated (n, q) in nT: the model as given, and the new one, along the measured motion.

    q = 3: body axes, each model as it stands. q = 1, without attitude: the field's strength, iron fitted anew; q = 2,
    with roll and pitch: also its dip, as an angle times the strength.
    """

    measured_nT: Array
    before_nT: Array
    after_nT: Array


@dataclass(frozen=True)
class GapAlongPath:
    """Means over stretches of so many samples (m of them): time, position (None: not recorded), gap in nT (m, q)."""

    samples: int
    time_s: Array
    pos_m: Array | None
    before_nT: Array
    after_nT: Array


def axes_of(found: Diagnosis) -> tuple[str, ...]:
    """Names of the compared values: body axes, or the field's strength, or this and its dip."""
    return found.problem.outputs


def compared_series(found: Diagnosis) -> ComparedSeries:
    """Both sides of the comparison at every sample."""
    problem = found.problem
    if problem.mode == "strength":
        measured = _given_nT(problem) + problem.target * problem.sigma_nT
        return ComparedSeries(measured, measured - found.before_nT, measured - found.after_nT)
    smooth = [effect for effect in found.model.chain() if not effect.traits.converter]
    return ComparedSeries(problem.recording.mag_nT, problem.predicted_nT, apply_deterministic(smooth, problem.state)[0])


def _given_nT(problem: LinearProblem) -> Array:
    """The given strength (n, 1), and with a level beside it the dip times the strength (n, 2)."""
    strength_nT = np.linalg.norm(problem.state.field_nT, axis=1, keepdims=True)
    if problem.level is None:
        return np.asarray(strength_nT)
    return np.concatenate([strength_nT, strength_nT * problem.level.given_rad(problem.track)[:, None]], axis=1)


def hidden_by_iron_refit(found: Diagnosis) -> bool:
    """Whether the finding shows in measured minus simulated as the models stand: iron fitted anew would take it up."""
    return found.problem.mode == "vector" and any(one.how is How.IRON for one in found.named)


def displayed_gap(found: Diagnosis) -> tuple[Array, Array]:
    """The gap before and after (n, q) in nT: iron fitted anew, or where that hides the finding as the models stand."""
    if not hidden_by_iron_refit(found):
        return found.before_nT, found.after_nT
    both = compared_series(found)
    return both.measured_nT - both.before_nT, both.measured_nT - both.after_nT


def rms_nT(found: Diagnosis, gap_nT: Array) -> float:
    """Root mean square of a gap (n, q) over the samples that are measurements."""
    return float(np.sqrt((gap_nT[found.problem.usable > 0] ** 2).mean()))


def gap_along_path(found: Diagnosis) -> GapAlongPath:
    """The gap in stretches of PLACE_S or longer, positions in metres from the first."""
    problem, (before_nT, after_nT) = found.problem, displayed_gap(found)
    n, pos = len(problem.recording), problem.recording.pos_enu_m
    length = max(round(BLOCK_S / problem.state.interval_s), -(-n // MOST_BLOCKS), 1)
    return GapAlongPath(
        length,
        block_means(problem.state.time_s, length),
        None if pos is None else block_means(relative_to_first(pos), length),
        block_means(before_nT, length, problem.usable),
        block_means(after_nT, length, problem.usable),
    )


def relative_to_first(pos_m: Array) -> Array:
    """Positions (n, 3) from the first: a map grid's are too large for a viewer's single precision."""
    return np.asarray(pos_m - pos_m[0])


def has_path(gap_along_path: GapAlongPath) -> bool:
    """Whether there is a path to draw."""
    return gap_along_path.pos_m is not None and float(np.ptp(gap_along_path.pos_m, axis=0).max()) > 0.1


def block_length(n: int, most: int) -> int:
    """Samples a block, so that at most so many blocks cover n samples."""
    return max(1, -(-n // most))


def block_means(values: Array, length: int, usable: Array | None = None) -> Array:
    """Means (m,) or (m, k) of values (n,) or (n, k) over blocks of so many samples, the last one perhaps shorter.

    usable (n,): weights 0 or 1; a block without any is NaN.
    """
    starts = np.arange(0, len(values), length)
    weight = np.ones(len(values)) if usable is None else usable
    shape = (-1, *[1] * (values.ndim - 1))
    count = np.add.reduceat(weight, starts).reshape(shape)
    total = np.add.reduceat(np.where(weight.reshape(shape) > 0, values, 0.0), starts, axis=0)
    return np.asarray(total / np.where(count > 0, count, np.nan))
