"""Period search for a pulsating field in the Earth's frame, under a coloured noise model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.evidence.hypothesis import Hypothesis, in_sample_gains, white_noise_model
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import in_axes
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers

LEAST_ROWS, MOST_ROWS, ROWS_A_PERIOD, TOGETHER = 500, 3000, 20, 24
"""Rows in the search, of them in the shortest period, and frequencies processed together: cost, not a decision."""
FINER, ROUNDS = 4, 6
"""Refinement factor of the frequency step, and number of refinements: down to a thousandth of a spectral line."""


def find_pulsations(baseline: Baseline, settings: dict[str, list[Candidate]]) -> tuple[Evidence, ...]:
    """Evidence of every effect with a period, from `fastest_pulse_s` to ``run / least_pulse_cycles``, if any.

    At the period of the largest gain under coloured noise.
    """
    policy, time_s = baseline.problem.policy, baseline.problem.state.time_s
    line_hz = 1 / float(time_s[-1] - time_s[0])
    tried = np.arange(policy.least_pulse_cycles * line_hz, 1 / policy.fastest_pulse_s, line_hz / 2)
    found = []
    for candidate, *_ in settings.values() if len(tried) else ():
        if (name := candidate.effect.with_role("period")) is not None:
            best_hz = _Swings.of(baseline, candidate).best(tried, line_hz / 2)
            found.append(judge_settings(baseline, [candidate.at({name: 1 / best_hz}, len(tried))]))
    return tuple(one for one in found if one is not None)


@dataclass(frozen=True, eq=False)
class _Swings:
    """Rows with accepted columns (n, q, k), middle times (n,), and unit fields (n, q, 3) east, north, up."""

    rows: BinnedRows
    accepted_columns: Array
    time_s: Array
    unit: Array

    @classmethod
    def of(cls, baseline: Baseline, candidate: Candidate) -> _Swings:
        problem, state = baseline.problem, baseline.problem.state
        wanted = round(ROWS_A_PERIOD * float(np.ptp(state.time_s)) / problem.policy.fastest_pulse_s)
        coarse = replace(problem.policy, most_rows=min(max(wanted, LEAST_ROWS), MOST_ROWS))
        rows = BinnedRows.of(state.time_s, problem.usable, problem.base, problem.target, coarse)
        axes = problem.whitened(candidate.seen(state.R_wb.transpose(0, 2, 1)), candidate.effect)
        middle_s = rows.row_start_s + (rows.interval_s - state.interval_s) / 2
        return cls(rows, rows.bin_groups(baseline.accepted_columns), middle_s, rows.bin(axes))

    def best(self, tried: Array, step: float) -> float:
        """The frequency of the largest gain: beside a smooth course on the grid `tried` (m,), then in finer steps."""
        x, white = self.time_s - self.time_s[0], white_noise_model(self.unit.shape[1])
        smooth = np.column_stack([np.ones(len(x)), powers(2 * x / x[-1] - 1, HIGHEST)])
        slow = np.concatenate([self.accepted_columns, in_axes(self.unit, smooth)], axis=2)
        noise_model = Hypothesis.of(self.rows, slow, (white,)).noise_model
        best = self._first(tried, slow, noise_model)
        swinging = np.concatenate([self.accepted_columns, self._wave(best)], axis=2)
        noise_model = Hypothesis.of(self.rows, swinging, (noise_model, white)).noise_model
        for _ in range(ROUNDS):
            near = np.maximum(best + step * np.linspace(-1, 1, 2 * FINER + 1), tried[0])
            best, step = self._first(near, self.accepted_columns, noise_model), step / FINER
        return best

    def _first(self, tried: Array, beside: Array, noise_model: NoiseModel) -> float:
        """The frequency of the largest gain beside columns (n, q, k) under a noise model."""
        parts = np.array_split(tried, -(-len(tried) // TOGETHER))
        nats = [in_sample_gains(self.rows, beside, [self._wave(hz) for hz in part], noise_model) for part in parts]
        return float(tried[np.argmax(np.concatenate(nats))])

    def _wave(self, hz: float) -> Array:
        """Columns (n, q, 6) of a wave with free phase, zero at the start."""
        angle = 2 * np.pi * hz * self.time_s
        return in_axes(self.unit, np.stack([np.sin(angle), np.cos(angle) - 1], axis=1))
