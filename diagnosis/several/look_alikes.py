"""Look-alikes of an effect in several recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.decision.white_choice import in_same_family
from diagnosis.evidence.hypothesis import information_matrices
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate, pool_estimates
from diagnosis.several.pooled_test import PooledCandidate, columns_in, estimate, held_out_nats
from diagnosis.several.transfer import Presence, TransferFinding
from scenarios.arrays import Array

Settings = dict[str, list[Candidate]]


def look_alikes(
    best: PooledCandidate, tried: Sequence[PooledCandidate], policy: Policy, *, coloured: bool
) -> tuple[list[PooledCandidate], list[PooledCandidate]]:
    """Return candidates as good as the best or of its family, the best first, and look-alikes in coloured noise."""
    explained = [rival for rival in tried if rival is not best and is_explained_by(rival.columns, best)]
    family_share = policy.same_family_coloured if coloured else policy.same_family

    def within(rival: PooledCandidate, share: float) -> bool:
        return best.gain - rival.gain < max(best.indistinct_nats, share * best.gain)

    closest = [rival for rival in explained if within(rival, family_share if in_same_family(rival, best) else 0.0)]
    return [best, *closest], [rival for rival in explained if coloured and within(rival, policy.same_coloured)]


def is_explained_by(columns: Sequence[Array | None], best: PooledCandidate) -> bool:
    """Whether a rival's columns keep little of their gain over all recordings once the best is fitted."""
    kept = alone = 0.0
    for rival_columns, best_in_recording in zip(columns, best.in_recordings, strict=True):
        if rival_columns is None or best_in_recording is None:
            continue
        baseline, noise_model = best_in_recording.baseline, best_in_recording.hypothesis.noise_model
        joint_columns = np.concatenate([baseline.columns_with(best_in_recording.columns), rival_columns], axis=2)
        best_alone = best_in_recording.hypothesis.held_out_log_likelihood
        kept += held_out_nats(baseline, joint_columns, noise_model) - best_alone
        alone += held_out_nats(baseline, baseline.columns_with(rival_columns), noise_model)
        alone -= held_out_nats(baseline, baseline.accepted_columns, noise_model)
    return kept / max(alone, 1e-9) < best.policy.half


def fit_equally_well(finding: TransferFinding, settings: Settings, problems: Sequence[LinearProblem]) -> list[str]:
    """Names of candidates fitting as well as the best where present, on all data, and adding nothing to the best.

    Losses of many columns on held-out data, and prices of searches, guard against false names, not against look-alikes.
    A candidate containing the best always fits as well; it is listed where it gains more than chance.
    """
    best = finding.pooled
    candidates = [candidate for listed in settings.values() for candidate in listed if candidate.name != best.name]
    columns = _where_present(finding, candidates, problems)
    gains = _fitted_gains(finding, list(columns.values()))
    best_gain = _fitted_gains(finding, [best.columns])[0]

    def least(candidate: Candidate) -> float:
        return best_gain + (
            best.indistinct_nats if best.name in candidate.effect.traits.contains else -best.indistinct_nats
        )

    close = [candidate for candidate, gain in zip(columns, gains, strict=True) if gain > least(candidate)]
    return list(dict.fromkeys(candidate.name for candidate in close if is_explained_by(columns[candidate], best)))


def _where_present(
    finding: TransferFinding, candidates: Sequence[Candidate], problems: Sequence[LinearProblem]
) -> dict[Candidate, list[Array | None]]:
    """Columns (n, q, k) in rows of the recordings with the effect, for candidates whose causes all of them hold."""
    columns: dict[Candidate, list[Array | None]] = {candidate: [] for candidate in candidates}
    for in_recording, presence, problem in zip(finding.pooled.in_recordings, finding.presence, problems, strict=True):
        for candidate in list(columns):
            whole = columns_in(candidate, problem)
            if in_recording is None or presence is not Presence.PRESENT:
                columns[candidate].append(None)
            elif whole is None:
                del columns[candidate]
            else:
                columns[candidate].append(in_recording.baseline.rows.bin(whole))
    return columns


def _fitted_gains(finding: TransferFinding, groups: Sequence[Sequence[Array | None]]) -> list[float]:
    """Nats explained in sample by groups of columns where an effect is present, with its noise models.

    One coefficient vector for all recordings, or one for each where the effect's coefficients differ.
    """
    estimates_of_groups: list[list[CoefficientEstimate]] = [[] for _ in groups]
    for i, (in_recording, presence) in enumerate(zip(finding.pooled.in_recordings, finding.presence, strict=True)):
        if in_recording is None or presence is not Presence.PRESENT:
            continue
        baseline, noise_model = in_recording.baseline, in_recording.hypothesis.noise_model
        columns = [group_columns for group in groups if (group_columns := group[i]) is not None]
        products = information_matrices(baseline.rows, baseline.accepted_columns, columns, noise_model)
        for estimates, product in zip(estimates_of_groups, products, strict=True):
            estimates.append(estimate(product))
    own_coefficients = finding.transfer is Transfer.NOT_TRANSFERRED
    return [
        sum(pooled.gain(pooled.c) for pooled in (estimates if own_coefficients else [pool_estimates(estimates)]))
        for estimates in estimates_of_groups
    ]
