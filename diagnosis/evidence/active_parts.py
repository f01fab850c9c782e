"""Segmentation of a recording into parts of steady residual power, each with its flight phase and heading."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import median_abs_deviation

from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from validation.signals.amplitude import rms
from validation.text import figure

Places = NDArray[np.int64]


@dataclass(frozen=True)
class ActivePart:
    """A time interval of the recording in s: share of the samples, flight phases, and the heading where steady.

    rms_nT, rms_sigma : rms of a residual there, in nT and in units of the noise.
    """

    from_s: float
    to_s: float
    share: float
    phase: str | None
    heading_deg: float | None
    rms_nT: float = 0.0
    rms_sigma: float = 0.0

    @classmethod
    def of(cls, problem: LinearProblem, from_s: float, to_s: float, residual: Array | None = None) -> ActivePart:
        """The interval with the phases that cover `phase_share` of it, compass heading of the mean x axis, and the size
        of a residual (n, q), if any.
        """
        time_s, phase = problem.state.time_s, problem.recording.phase
        inside = (time_s >= from_s) & (time_s < to_s)
        part = cls(from_s, to_s, float(inside.mean()), None, None)
        if phase is not None and inside.any():
            names, first, count = np.unique(phase[inside], return_index=True, return_counts=True)
            kept = count >= problem.policy.phase_share * count.sum()
            part = replace(part, phase=", ".join(names[kept][np.argsort(first[kept])]))
        if problem.recording.att_q is not None and inside.any():
            east, north = problem.state.R_wb[inside][:, :2, 0].mean(axis=0)
            if np.hypot(east, north) >= problem.policy.nearly_all:
                part = replace(part, heading_deg=float(np.degrees(np.arctan2(east, north)) % 360.0))
        if residual is None:
            return part
        some = residual[inside & (problem.usable > 0)]
        return replace(part, rms_nT=rms(some * problem.sigma_nT), rms_sigma=rms(some))

    @property
    def words(self) -> str:
        """ "from 312 s to 548 s (phase spiral, heading 90°, 19 % of the run)"."""
        phase = f"phase {self.phase}, " if self.phase else ""
        heading = "" if self.heading_deg is None else f"heading {self.heading_deg:.0f}°, "
        return (
            f"from {figure(self.from_s, 4)} s to {figure(self.to_s, 4)} s "
            f"({phase}{heading}{100 * self.share:.0f} % of the run)"
        )


def split_by_power(problem: LinearProblem, residual: Array) -> tuple[ActivePart, ...]:
    """Split a recording at changes of the residual's power; residual (n, q) in units of the noise.

    ``min sum_parts sum_cells (ln P - mean)^2 / noise^2 + price ln m`` over m cells, P the mean square of a cell; the
    noise of ``ln P`` is the scatter of neighbouring cells.
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
    ends_s = ends_s[edges[[0, *cuts, -1]]].tolist()
    return tuple(ActivePart.of(problem, first, last, residual) for first, last in itertools.pairwise(ends_s))


def largest_part(parts: tuple[ActivePart, ...], policy: Policy) -> ActivePart | None:
    """The part with the largest gap, if far larger than the gap of the remaining parts; else None."""
    if len(parts) < 2:
        return None
    *others, most = sorted(parts, key=lambda part: part.rms_sigma)
    elsewhere = np.average([part.rms_sigma**2 - 1 for part in others], weights=[part.share for part in others])
    return most if most.rms_sigma**2 - 1 > policy.far_larger * max(elsewhere, policy.hardly_any) else None


def _cuts(log_power: Array, policy: Policy) -> Places:
    """First cells (c,) of the parts after the first: the cheapest partition, by dynamic programming."""
    m = len(log_power)
    noise = max(median_abs_deviation(np.diff(log_power), scale="normal") / np.sqrt(2), 1e-6)
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
    cuts = [int(before[-1])]
    while cuts[-1] > 0:
        cuts.append(int(before[cuts[-1]]))
    return np.array(cuts[-2::-1], dtype=np.int64)
