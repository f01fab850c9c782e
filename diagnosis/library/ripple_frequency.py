"""The frequency of a ripple that a current drives: lines of a spectrum, then between them."""

from __future__ import annotations

import numpy as np

from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.resampling import SPARSEST


def tones(problem: LinearProblem, residual: Array, member: Candidate) -> list[Candidate]:
    """The strongest line in the spectrum of residual (n, q) times current; both phases belong to it.

    Times what a unit on each axis would add: along a field that turns, a steady tone comes and goes.
    """
    name = member.effect.with_role("frequency")
    assert name is not None
    interval_s, policy = problem.state.interval_s, problem.policy
    unit_nT = _drive(problem, member)[:, None, None] * np.eye(3)
    weighted = np.einsum("nq,nqk->nk", residual, problem.whitened(unit_nT, member.effect))
    even = _in_slots(weighted, problem.state.time_s, interval_s)
    n = len(even)
    power = (np.abs(np.fft.rfft(even, axis=0)) ** 2).sum(axis=1)
    f = np.fft.rfftfreq(n, interval_s)
    power[f < max(policy.slowest_tone_hz, policy.least_tone_cycles / (n * interval_s))] = 0.0
    tone_hz = _between_lines(weighted, problem.state.time_s, f[int(np.argmax(power))], f[1])
    return [member.at({name: tone_hz}, len(f))]


def _in_slots(weighted: Array, time_s: Array, interval_s: float) -> Array:
    """Values (m, q) in slots of even time, zero in gaps; of a recording that is mostly gaps as they come."""
    place = np.rint((time_s - time_s[0]) / interval_s).astype(np.intp)
    if place[-1] >= SPARSEST * len(time_s):
        return weighted
    even = np.zeros((int(place[-1]) + 1, weighted.shape[1]))
    np.add.at(even, place, weighted)
    return even


def _drive(problem: LinearProblem, member: Candidate) -> Array:
    """The current (n,) of the candidate's motor, or of all of them."""
    name = member.effect.with_role("motor")
    motor = dict(member.nonlinear).get(name, 0) if name else 0
    return problem.state.current_of(motor)


def _between_lines(weighted: Array, time_s: Array, frequency_hz: float, line_hz: float) -> float:
    """The strongest frequency within a line of the spectrum, to a hundredth of a line."""
    centre, step = frequency_hz, line_hz / 2
    for _ in range(4):
        tried = centre + step * np.linspace(-1, 1, 9)
        turn = np.exp(-2j * np.pi * tried[:, None] * time_s)
        power = (np.abs(turn @ weighted) ** 2).sum(axis=1)
        centre, step = float(tried[int(np.argmax(power))]), step / 4
    return max(centre, 1e-6)
