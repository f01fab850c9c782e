"""A field that swings: the period that stands out most of a rest with its own colour, in the earth's frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, judged_at
from diagnosis.evidence.hypothesis import Hypothesis, gains, white
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import in_axes
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers

ROWS, TOGETHER = 3000, 24
"""Most rows that the search sees, and frequencies whose columns are held at once: an effort, not a decision."""
FINER, ROUNDS = 4, 6
"""Times that the step between frequencies is made finer, and how often: to a thousandth of a line."""


def pulses(ground: Baseline, members: dict[str, list[Candidate]]) -> tuple[Evidence, ...]:
    """The evidence of every effect with a period, at the one that gains most beside a rest with its own colour."""
    found = (
        judged_at(ground, [one])
        for several in members.values()
        if (name := several[0].effect.with_role("period"))
        for one in _at_best_period(ground, several[0], name)
    )
    return tuple(one for one in found if one is not None)


def _at_best_period(ground: Baseline, member: Candidate, name: str) -> Iterator[Candidate]:
    """The candidate at the best of its periods, from `fastest_pulse_s` to `least_pulse_cycles` of the run, if any."""
    policy, time_s = ground.problem.policy, ground.problem.state.time_s
    line_hz = 1 / float(time_s[-1] - time_s[0])
    low, high = policy.least_pulse_cycles * line_hz, 1 / policy.fastest_pulse_s
    if low < high:
        tried = np.arange(low, high, line_hz / 2)
        yield member.at({name: 1 / _Swings.of(ground, member).best(tried, line_hz / 2)}, len(tried))


@dataclass(frozen=True, eq=False)
class _Swings:
    """Rows with what is in (n, q, k), their middle times (n,), and a unit along east, north and up (n, q, 3)."""

    rows: BinnedRows
    inside: Array
    time_s: Array
    unit: Array

    @classmethod
    def of(cls, ground: Baseline, member: Candidate) -> _Swings:
        problem, state = ground.problem, ground.problem.state
        coarse = replace(problem.policy, most_rows=ROWS)
        rows = BinnedRows.of(state.time_s, problem.usable, problem.base, problem.target, coarse)
        axes = problem.whitened(state.R_wb.transpose(0, 2, 1), member.effect)
        middle_s = rows.row_s + (rows.interval_s - state.interval_s) / 2
        return cls(rows, rows.all_taken(ground.inside), middle_s, rows.taken(axes))

    def best(self, tried: Array, step: float) -> float:
        """The frequency of most nats: of those tried (m,), a step apart, then near it beside what it leaves."""
        slow = self._with(self._slow())
        rest = Hypothesis.of(self.rows, slow, (white(slow.shape[1]),)).rest
        best = self._first(tried, slow, rest)
        left = Hypothesis.of(self.rows, self._with(self._wave(best)), (rest, white(slow.shape[1]))).rest
        for _ in range(ROUNDS):
            near = np.maximum(best + step * np.linspace(-1, 1, 2 * FINER + 1), tried[0])
            best, step = self._first(near, self.inside, left), step / FINER
        return best

    def _first(self, tried: Array, inside: Array, rest: NoiseModel) -> float:
        """The frequency of most nats beside columns (n, q, k) and a rest."""
        parts = np.array_split(tried, -(-len(tried) // TOGETHER))
        nats = [gains(self.rows, inside, [self._wave(hz) for hz in part], rest) for part in parts]
        return float(tried[np.argmax(np.concatenate(nats))])

    def _wave(self, hz: float) -> Array:
        """Columns (n, q, 6) of a wave of any phase that is zero at the start of time."""
        angle = 2 * np.pi * hz * self.time_s
        return in_axes(self.unit, np.stack([np.sin(angle), np.cos(angle) - 1], axis=1))

    def _slow(self) -> Array:
        """Columns (n, q, k) of a constant and of a smooth course of the run."""
        x = 2 * (self.time_s - self.time_s[0]) / (self.time_s[-1] - self.time_s[0]) - 1
        return np.concatenate([self.unit, in_axes(self.unit, powers(x, HIGHEST))], axis=2)

    def _with(self, columns: Array) -> Array:
        return np.concatenate([self.inside, columns], axis=2)
