"""A first look at the candidates of a round, beside the rest as it is: which are tried, and in which order."""

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
    """A first look at candidates: their columns as rows, the nats (m,) that each gains within rows, and in all."""

    several: Sequence[Evidence]
    columns: Sequence[Array]
    within: Array
    nats: Array

    @classmethod
    def of(cls, several: Sequence[Evidence], beside: ColouredBaseline, ground: Baseline) -> Screening:
        """Beside the rest as it is."""
        columns, within = _in_rows(several, beside, ground)
        return cls(several, columns, within, beside.roughly(columns) + within)

    def in_turn(self, ground: Baseline, start: Baseline) -> list[int]:
        """One candidate of each name in the order of their nats, those behind that explain next to nothing of the gap.

        What an iron that is fitted anew moves about gains much beside a slow rest; it takes no turn from what explains.
        """
        kept = one_of_each([one.name for one in self.several], self.nats, ground.problem.policy)
        shares = {i: added_share(start, ground, self.several[i].squares) for i in kept}
        return sorted(kept, key=lambda i: (shares[i] < ground.problem.policy.least_added, -self.nats[i]))

    def heard(self, one: int, beside: ColouredBaseline) -> CandidateFit:
        """A candidate beside a rest of its own, or another of its name that gains more there."""
        name = self.several[one].name
        same = [i for i, other in enumerate(self.several) if other.name == name]
        several = [beside.standing(self.several[i], self.columns[i], self.within[i]) for i in same]
        (best,) = one_of_each([name] * len(same), np.array([each.gain for each in several]), beside.rows.policy)
        return several[best]


def one_of_each(names: Sequence[str], nats: Array, policy: Policy) -> list[int]:
    """The best of each name; a later one is taken where it gains more by an error of form.

    For forms are fitted once the effect is in.
    """
    best: dict[str, int] = {}
    for i, name in enumerate(names):
        before = best.setdefault(name, i)
        if nats[i] > nats[before] + max(policy.apart, policy.same_coloured * nats[before]):
            best[name] = i
    return list(best.values())


def _in_rows(ranking: Sequence[Evidence], beside: ColouredBaseline, ground: Baseline) -> tuple[list[Array], Array]:
    """The columns of candidates as rows, and the nats (m,) that each gains between the samples of a row."""
    columns, within = [], np.zeros(len(ranking))
    for i, one in enumerate(ranking):
        whole = one.candidate.columns(ground.problem)
        columns.append(beside.rows.taken(whole))
        within[i] = gain_within(ground.problem, beside.rows, ground.inside, whole)
    return columns, within
