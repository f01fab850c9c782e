"""First look at a round's candidates under one noise model, and the fits of the best, each with its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.held_out import Evidence, on_six_digits
from diagnosis.evidence.within_row import gain_within
from diagnosis.policy import Policy
from scenarios.arrays import Array


def screen(
    candidates: Sequence[Evidence], beside: ColouredBaseline, baseline: Baseline, start: Baseline
) -> tuple[list[CandidateFit], list[tuple[Evidence, float]]]:
    """Fit the best candidates, each with a noise model of its own, the strongest first.

    The order is that of the nats by the noise model of all, with candidates of a negligible share of the gap last:
    refitted iron follows slow noise, and gains much. Returned with the other candidates and their nats.
    """
    policy, names = baseline.problem.policy, [evidence.name for evidence in candidates]
    columns, within = _in_rows(candidates, beside, baseline)
    nats = beside.screening_gains(columns) + within
    negligible = [added_share(start, baseline, evidence.squares) < policy.trace for evidence in candidates]
    order = sorted(
        best_of_each_name(names, nats, policy), key=lambda i: (negligible[i], -on_six_digits(float(nats[i])))
    )
    tried = {names[i] for i in order[: policy.tried_coloured]}
    settings = (each for each in zip(candidates, columns, within, strict=True) if each[0].name in tried)
    fits = [beside.fit_candidate(*each) for each in settings]
    best = best_of_each_name([fit.evidence.name for fit in fits], np.array([fit.gain for fit in fits]), policy)
    screened = [(candidates[i], float(nats[i])) for i in order[policy.tried_coloured :]]
    return sorted((fits[i] for i in best), key=lambda fit: -on_six_digits(fit.gain)), screened


def _in_rows(
    candidates: Sequence[Evidence], beside: ColouredBaseline, baseline: Baseline
) -> tuple[list[Array], list[float]]:
    """Columns (n, q, k) of candidates in rows, and the nats that each gains within the rows."""
    columns, within = list[Array](), list[float]()
    for evidence in candidates:  # whole columns are large: one candidate at a time
        whole = evidence.candidate.columns(baseline.problem)
        columns.append(beside.rows.bin(whole))
        within.append(gain_within(baseline.problem, beside.rows, baseline.accepted_columns, whole))
    return columns, within


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
