"""Tones without an electrical cause: harmonics of the heading in a steady turn, or a pulsation of the field."""

from __future__ import annotations

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def follows_heading(baseline: Baseline, evidence: Evidence) -> bool:
    """Whether the heading psi explains as much of the baseline's residual as a candidate tone of frequency f.

    The tone's columns along ``k psi(t)`` in place of ``2 pi f t``, k the integer nearest to f over the median turn
    rate. False for effects without a frequency, without attitude, or for k above `most_lobes`.
    """
    problem = baseline.problem
    name = evidence.candidate.effect.with_role("frequency")
    if name is None or evidence.candidate.phase is None or problem.mode != "vector":
        return False
    angle = 2 * np.pi * float(dict(evidence.candidate.nonlinear)[name]) * problem.state.time_s
    heading = _heading_rad(problem)
    lobes = _times(np.diff(angle), np.diff(heading))
    if not 1 <= lobes <= problem.policy.most_lobes:
        return False
    tone = evidence.candidate.columns(problem)
    turned = _turned(tone, lobes * heading - angle)
    return baseline.evidence_of(turned) > baseline.evidence_of(tone) - problem.policy.apart


def follows_earth_frame(baseline: Baseline, evidence: Evidence) -> bool:
    """Whether a tone along the Earth's axes explains more of the baseline's residual than a current's tone.

    Fields of swell and pulsations are fixed to the Earth's axes, and rotate in the sensor frame as the vehicle turns.
    """
    problem, name = baseline.problem, evidence.candidate.effect.with_role("frequency")
    if name is None or evidence.candidate.phase is None or problem.mode != "vector":
        return False
    angle = 2 * np.pi * float(dict(evidence.candidate.nonlinear)[name]) * problem.state.time_s
    axes = problem.state.R_wb.transpose(0, 2, 1)
    swing = np.concatenate([axes * np.sin(angle)[:, None, None], axes * np.cos(angle)[:, None, None]], axis=2)
    of_field = baseline.evidence_of(problem.field_columns(swing))
    return of_field > baseline.evidence_of(evidence.candidate.columns(problem)) + problem.policy.apart


def _heading_rad(problem: LinearProblem) -> Array:
    """Unwrapped heading (n,)."""
    R = problem.state.R_wb
    return np.asarray(np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0])))


def _times(fast: Array, slow: Array) -> int:
    """Ratio of the medians of |fast| and |slow|, rounded; 0 where the median of |slow| is 0."""
    step = float(np.median(np.abs(slow)))
    return round(float(np.median(np.abs(fast))) / step) if step > 0 else 0


def _turned(tone: Array, ahead: Array) -> Array:
    """Columns (n, q, 2 k) of a sine and a cosine, their phase advanced by an angle (n,)."""
    sine, cosine = np.split(tone, 2, axis=2)
    c, s = (part[:, None, None] for part in (np.cos(ahead), np.sin(ahead)))
    return np.concatenate([sine * c + cosine * s, cosine * c - sine * s], axis=2)
