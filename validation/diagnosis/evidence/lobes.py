"""A tone that is a lobe of the heading: a vehicle that turns evenly makes tones of what follows its heading."""

from __future__ import annotations

import numpy as np

from sim.state import Array
from validation.diagnosis.evidence.compare import Evidence
from validation.diagnosis.evidence.ground import Ground
from validation.diagnosis.problem.linear import LinearProblem


def goes_with_heading(ground: Ground, one: Evidence) -> bool:
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
