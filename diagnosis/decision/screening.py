"""Screening of a round's candidates with a common noise model: choice and order of the candidates to test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.within_row import gain_within
from diagnosis.policy import Policy
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class Screening:
    """Candidates, their columns in binned rows, and the nats (m,) gained within rows and in total."""

    candidates: Sequence[Evidence]
    columns: Sequence[Array]
    within: Array
    nats: Array

    @classmethod
    def of(cls, candidates: Sequence[Evidence], coloured_baseline: ColouredBaseline, baseline: Baseline) -> Screening:
        """Screen candidates with the noise model of the baseline."""
        rows, problem, columns, within = coloured_baseline.rows, baseline.problem, [], []
        for evidence in candidates:  # whole columns are large: one candidate at a time
            whole = evidence.candidate.columns(problem)
            columns.append(rows.bin(whole))
            within.append(gain_within(problem, rows, baseline.accepted_columns, whole))
        return cls(candidates, columns, np.array(within), coloured_baseline.screening_gains(columns) + within)

    def order(self, baseline: Baseline, start: Baseline) -> list[int]:
        """Index of one candidate for each name, by decreasing nats, with negligible shares of the gap last.

        Negligible candidates may gain much: refitted iron follows slow noise.
        """
        kept = best_of_each_name([one.name for one in self.candidates], self.nats, baseline.problem.policy)
        shares = {index: added_share(start, baseline, self.candidates[index].squares) for index in kept}
        return sorted(kept, key=lambda index: (shares[index] < baseline.problem.policy.trace, -self.nats[index]))

    def best_fit(self, index: int, coloured_baseline: ColouredBaseline) -> CandidateFit:
        """Fit an effect with its own noise model, at the setting of largest gain."""
        name = self.candidates[index].name
        fits = [
            coloured_baseline.fit_candidate(*each)
            for each in zip(self.candidates, self.columns, self.within, strict=True)
            if each[0].name == name
        ]
        gains = np.array([fit.gain for fit in fits])
        return fits[best_of_each_name([name] * len(fits), gains, coloured_baseline.rows.policy)[0]]


def best_of_each_name(names: Sequence[str], nats: Array, policy: Policy) -> list[int]:
    """The best index for each name; a later one wins only where it gains more than a form error.

    Forms are fitted once the effect is accepted.
    """
    best: dict[str, int] = {}
    for i, name in enumerate(names):
        before = best.setdefault(name, i)
        if nats[i] > nats[before] + max(policy.apart, policy.same_coloured * nats[before]):
            best[name] = i
    return list(best.values())
