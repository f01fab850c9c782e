"""When the gap is large: parts of the recording in which its size is steady, each with phase and heading."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from validation.signals.amplitude import rms

Places = NDArray[np.int64]
NORMAL_MAD = 1.4826
"""Standard deviations of a normal distribution in its median absolute deviation."""


@dataclass(frozen=True)
class ActivePart:
    """A stretch of time in s of the run: its share of the run, its phases, and its heading where that is steady."""

    from_s: float
    to_s: float
    share: float
    phase: str | None
    heading_deg: float | None

    @classmethod
    def of(cls, problem: LinearProblem, from_s: float, to_s: float) -> ActivePart:
        """What is known of a stretch of a recording."""
        time_s = problem.state.time_s
        inside = (time_s >= from_s) & (time_s < to_s)
        share = float(inside.mean())
        return cls(from_s, to_s, share, _phase(problem, inside), _heading_deg(problem, inside))

    @property
    def words(self) -> str:
        """ "from 312 s to 548 s (phase spiral, heading 90°, 19 % of the run)"."""
        phase = f"phase {self.phase}, " if self.phase else ""
        heading = "" if self.heading_deg is None else f"heading {self.heading_deg:.0f}°, "
        return f"from {self.from_s:.4g} s to {self.to_s:.4g} s ({phase}{heading}{100 * self.share:.0f} % of the run)"


@dataclass(frozen=True)
class Part:
    """A stretch and the gap's rms in it, in nT and in units of the noise."""

    stretch: ActivePart
    rms_nT: float
    rms_sigma: float


def parts_of(problem: LinearProblem, residual: Array) -> tuple[Part, ...]:
    """The recording in parts between which the size of a residual (n, q), in units of the noise, changes.

    Least squares of the log power of cells with a price for each part; the cells' noise is read from neighbours.
    """
    n, policy = len(residual), problem.policy
    edges = np.unique(np.linspace(0, n, policy.part_cells + 1).astype(np.int64))
    count = np.add.reduceat(problem.usable, edges[:-1])
    power = np.add.reduceat((residual**2).mean(axis=1), edges[:-1]) / np.maximum(count, 1)
    there = count > policy.filled_block * np.diff(edges)
    if np.count_nonzero(there) < 2:
        return ()
    cuts = np.flatnonzero(there)[_cuts(np.log(np.maximum(power[there], 1e-12)), policy)]
    ends_s = np.append(problem.state.time_s, problem.state.time_s[-1] + problem.state.interval_s)
    bounds = edges[np.concatenate([[0], cuts, [len(edges) - 1]])]
    return tuple(
        _part(problem, residual, a, b, ActivePart.of(problem, float(ends_s[a]), float(ends_s[b])))
        for a, b in itertools.pairwise(bounds)
    )


def largest(parts: tuple[Part, ...], policy: Policy) -> Part | None:
    """The part in which the gap is largest, if it is far larger there than in the rest and takes a part of the run."""
    if len(parts) < 2:
        return None
    most = max(parts, key=lambda one: one.rms_sigma)
    others = [one for one in parts if one is not most]
    weight = np.array([one.stretch.share for one in others])
    excess = np.array([one.rms_sigma**2 - 1 for one in others])
    rest = float(weight @ excess) / max(float(weight.sum()), 1e-9)
    return most if most.rms_sigma**2 - 1 > policy.far_larger * max(rest, policy.least_held_excess) else None


def _part(problem: LinearProblem, residual: Array, a: int, b: int, stretch: ActivePart) -> Part:
    some = residual[a:b][problem.usable[a:b] > 0]
    return Part(stretch, rms(some * problem.sigma_nT), rms(some))


def _cuts(log_power: Array, policy: Policy) -> Places:
    """Cells (c,) before which a new part begins: the cheapest partition, by dynamic programming."""
    m = len(log_power)
    noise = max(NORMAL_MAD * float(np.median(np.abs(np.diff(log_power)))) / np.sqrt(2), 1e-6)
    first, second = (np.concatenate([[0.0], np.cumsum((log_power / noise) ** k)]) for k in (1, 2))
    shortest = math.ceil(policy.least_part * m)
    best, before = np.full(m + 1, np.inf), np.zeros(m + 1, dtype=np.int64)
    best[0] = 0.0
    for j in range(shortest, m + 1):
        i = np.arange(j - shortest + 1)
        squares = second[j] - second[i] - (first[j] - first[i]) ** 2 / (j - i)
        cost = best[i] + squares + policy.part_price * np.log(m)
        before[j] = int(np.argmin(cost))
        best[j] = cost[before[j]]
    return _traced(before)


def _traced(before: Places) -> Places:
    """Where the parts begin (c,), from the beginning of the last part of each length."""
    cuts: list[int] = []
    at = int(before[-1])
    while at > 0:
        cuts.append(at)
        at = int(before[at])
    return np.array(cuts[::-1], dtype=np.int64)


def _phase(problem: LinearProblem, inside: NDArray[np.bool_]) -> str | None:
    """The phases that make up a tenth of a stretch and more, in their order."""
    phase = problem.recording.phase
    if phase is None or not inside.any():
        return None
    names, first, count = np.unique(phase[inside], return_index=True, return_counts=True)
    kept = count >= problem.policy.phase_share * count.sum()
    return ", ".join(str(name) for _, name in sorted(zip(first[kept], names[kept], strict=True)))


def _heading_deg(problem: LinearProblem, inside: NDArray[np.bool_]) -> float | None:
    """The compass heading of a stretch whose x axis hardly turns, None without attitude or on a turn."""
    if problem.recording.att_q is None or not inside.any():
        return None
    ahead = problem.state.R_wb[inside][:, :2, 0].mean(axis=0)
    if np.hypot(*ahead) < problem.policy.steady_heading:
        return None
    return float(np.degrees(np.arctan2(ahead[0], ahead[1])) % 360.0)
