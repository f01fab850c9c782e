"""Series of a diagnosis for plots and the viewer: measured, simulated and gap over time, and the gap along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, EvidenceKind
from scenarios.arrays import Array
from sim.chain import apply_deterministic

MOST_BLOCKS, BLOCK_S = 4000, 1.0
"""Of the gap along the path: points at most, and the shortest time that one is the mean of."""


@dataclass(frozen=True)
class ComparedSeries:
    """Measured values and two simulations along the measured motion, (n, q) in nT: the given model and the new model.

    q = 3: body axes, models without refit. q = 1, without attitude: field strength, iron refitted. q = 2, with roll and
    pitch: field strength and dip, the dip as angle times strength.
    """

    measured_nT: Array
    before_nT: Array
    after_nT: Array


@dataclass(frozen=True)
class GapAlongPath:
    """Block means of the gap along the path: m blocks of `samples` samples each.

    time_s (m,); pos_m (m, 3), None if not recorded; before_nT and after_nT (m, q): gap of the given and the new model.
    """

    samples: int
    time_s: Array
    pos_m: Array | None
    before_nT: Array
    after_nT: Array


def compared_series(diagnosis: Diagnosis) -> ComparedSeries:
    """Return the measured and the simulated values at every sample."""
    problem = diagnosis.problem
    if problem.mode == "strength":
        measured = _given_nT(problem) + problem.target * problem.sigma_nT
        return ComparedSeries(measured, measured - diagnosis.before_nT, measured - diagnosis.after_nT)
    smooth = [effect for effect in diagnosis.model.chain() if not effect.traits.converter]
    return ComparedSeries(problem.recording.mag_nT, problem.predicted_nT, apply_deterministic(smooth, problem.state)[0])


def _given_nT(problem: LinearProblem) -> Array:
    """Return the given strength (n, 1); with roll and pitch also the dip times the strength (n, 2)."""
    strength_nT = np.linalg.norm(problem.state.field_nT, axis=1, keepdims=True)
    if problem.level is None:
        return np.asarray(strength_nT)
    return np.concatenate([strength_nT, strength_nT * problem.level.given_rad(problem.track)[:, None]], axis=1)


def hidden_by_iron_refit(diagnosis: Diagnosis) -> bool:
    """Return whether a refit of the iron would absorb the cause, so that the gap is shown without the refit."""
    return diagnosis.problem.mode == "vector" and any(one.kind is EvidenceKind.IRON for one in diagnosis.named)


def displayed_gap(diagnosis: Diagnosis) -> tuple[Array, Array]:
    """Return the gap (n, q) in nT before and after: with iron refitted, or without where the refit hides the cause."""
    if not hidden_by_iron_refit(diagnosis):
        return diagnosis.before_nT, diagnosis.after_nT
    both = compared_series(diagnosis)
    return both.measured_nT - both.before_nT, both.measured_nT - both.after_nT


def rms_nT(diagnosis: Diagnosis, gap_nT: Array) -> float:
    """Return the root mean square of a gap (n, q) over the usable samples."""
    return float(np.sqrt((gap_nT[diagnosis.problem.usable > 0] ** 2).mean()))


def gap_along_path(diagnosis: Diagnosis) -> GapAlongPath:
    """Return the gap in blocks of BLOCK_S or longer, with positions in metres from the first."""
    problem, (before_nT, after_nT) = diagnosis.problem, displayed_gap(diagnosis)
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
    """Return positions (n, 3) relative to the first: map coordinates exceed a viewer's single precision."""
    return np.asarray(pos_m - pos_m[0])


def has_path(gap_along_path: GapAlongPath) -> bool:
    """Return whether the positions extend over more than 0.1 m."""
    return gap_along_path.pos_m is not None and float(np.ptp(gap_along_path.pos_m, axis=0).max()) > 0.1


def block_length(n: int, most: int) -> int:
    """Return the number of samples in a block, for at most `most` blocks over n samples."""
    return max(1, -(-n // most))


def block_means(values: Array, length: int, usable: Array | None = None) -> Array:
    """Return means (m,) or (m, k) of values (n,) or (n, k) over blocks of `length` samples, the last perhaps shorter.

    usable (n,): weights 0 or 1; a block without usable samples is NaN.
    """
    starts = np.arange(0, len(values), length)
    weight = np.ones(len(values)) if usable is None else usable
    shape = (-1, *[1] * (values.ndim - 1))
    count = np.add.reduceat(weight, starts).reshape(shape)
    total = np.add.reduceat(np.where(weight.reshape(shape) > 0, values, 0.0), starts, axis=0)
    return np.asarray(total / np.where(count > 0, count, np.nan))


def value_axis_low(gap_nT: Array) -> float | None:
    """Return the lower end of a symmetric value axis for a gap (n, q), the same before and after; None for no gap."""
    thin = block_means(gap_nT, block_length(len(gap_nT), MOST_BLOCKS))
    return -1.5 * float(np.nanmax(np.abs(thin))) or None
