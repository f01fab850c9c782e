"""A tone that is no motor's: a lobe of the heading of a vehicle that turns evenly, or a swing of the field itself."""

from __future__ import annotations

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.earth import RegionalField


def goes_with_heading(ground: Baseline, one: Evidence) -> bool:
    """Whether the heading psi explains as much of what a ground leaves as a tone of frequency f does.

    The same columns along ``k psi(t)`` instead of ``2 pi f t``, k the whole number nearest to f over the median rate of
    the turn. None is asked of an effect that is no tone, without attitude, or beyond `most_lobes`.
    """
    problem = ground.problem
    name = one.candidate.effect.with_role("frequency")
    if name is None or one.candidate.phase is None or problem.mode != "vector":
        return False
    angle = 2 * np.pi * float(dict(one.candidate.nonlinear)[name]) * problem.state.time_s
    heading = _heading_rad(problem)
    lobes = _times(np.diff(angle), np.diff(heading))
    if not 1 <= lobes <= problem.policy.most_lobes:
        return False
    tone = one.candidate.columns(problem)
    turned = _turned(tone, lobes * heading - angle)
    return ground.evidence_of(turned) > ground.evidence_of(tone) - problem.policy.apart


def swings_with_the_field(ground: Baseline, one: Evidence) -> bool:
    """Whether a tone along the earth's axes explains more of what a ground leaves than one that a current drives.

    So do a swell's and a pulsation's, and turn the other way as the vehicle turns.
    """
    problem, name = ground.problem, one.candidate.effect.with_role("frequency")
    if name is None or one.candidate.phase is None or problem.mode != "vector":
        return False
    angle = 2 * np.pi * float(dict(one.candidate.nonlinear)[name]) * problem.state.time_s
    axes = problem.state.R_wb.transpose(0, 2, 1)
    swing = np.concatenate([axes * np.sin(angle)[:, None, None], axes * np.cos(angle)[:, None, None]], axis=2)
    of_field = ground.evidence_of(problem.whitened(swing, RegionalField))
    return of_field > ground.evidence_of(one.candidate.columns(problem)) + problem.policy.apart


def _heading_rad(problem: LinearProblem) -> Array:
    """The heading (n,) without its jumps of a turn."""
    R = problem.state.R_wb
    return np.asarray(np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0])))


def _times(fast: Array, slow: Array) -> int:
    """How many times the median of |slow| is in that of |fast|, rounded; 0 where slow stands."""
    step = float(np.median(np.abs(slow)))
    return round(float(np.median(np.abs(fast))) / step) if step > 0 else 0


def _turned(tone: Array, ahead: Array) -> Array:
    """Columns (n, q, 2 k) of a sine and a cosine, with their angle (n,) so far ahead."""
    sine, cosine = np.split(tone, 2, axis=2)
    c, s = (part[:, None, None] for part in (np.cos(ahead), np.sin(ahead)))
    return np.concatenate([sine * c + cosine * s, cosine * c - sine * s], axis=2)
