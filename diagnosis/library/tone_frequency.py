"""Frequency search for a steady tone, or a ripple driven by a current: spectral lines, then between lines."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.resampling import SPARSEST


def find_tones(problem: LinearProblem, residual: Array, candidate: Candidate) -> list[Candidate]:
    """The candidate at the strongest line in the spectrum of residual (n, q) times current; either phase is included.

    The product also contains the direction of each axis: along a rotating field the amplitude of a steady tone is
    modulated.
    """
    name = candidate.effect.with_role("frequency")
    assert name is not None
    interval_s, policy = problem.state.interval_s, problem.policy
    motor = candidate.effect.with_role("motor")
    drive_A = problem.state.current_of(dict(candidate.nonlinear).get(motor, 0)) if motor else np.ones(len(residual))
    unit_nT = drive_A[:, None, None] * np.eye(3)
    weighted = np.einsum("nq,nqk->nk", residual, problem.whitened(unit_nT, candidate.effect))
    even = _in_slots(weighted, problem.state.time_s, interval_s)
    n = len(even)
    power = (np.abs(np.fft.rfft(even, axis=0)) ** 2).sum(axis=1)
    f = np.fft.rfftfreq(n, interval_s)
    power[f < max(policy.slowest_tone_hz, policy.least_tone_cycles / (n * interval_s))] = 0.0
    tone_hz = _between_lines(weighted, problem.state.time_s, f[int(np.argmax(power))], f[1])
    return [candidate.at({name: tone_hz}, len(f))]


def _in_slots(weighted: Array, time_s: Array, interval_s: float) -> Array:
    """Values (m, q) in evenly spaced slots, zero in gaps; unchanged for a recording with more gaps than samples."""
    place = np.rint((time_s - time_s[0]) / interval_s).astype(np.intp)
    if place[-1] >= SPARSEST * len(time_s):
        return weighted
    even = np.zeros((int(place[-1]) + 1, weighted.shape[1]))
    np.add.at(even, place, weighted)
    return even


def _between_lines(weighted: Array, time_s: Array, frequency_hz: float, line_hz: float) -> float:
    """Frequency of the largest power within a spectral line, to a hundredth of a line."""
    centre, step = frequency_hz, line_hz / 2
    for _ in range(4):
        tried = centre + step * np.linspace(-1, 1, 9)
        turn = np.exp(-2j * np.pi * tried[:, None] * time_s)
        power = (np.abs(turn @ weighted) ** 2).sum(axis=1)
        centre, step = float(tried[int(np.argmax(power))]), step / 4
    return max(centre, 1e-6)
