"""Look-alikes of an effect in several recordings."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.decision.white_choice import in_same_family
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import pool_estimates
from diagnosis.several.pooled_test import PooledCandidate, estimates_beside
from diagnosis.several.transfer import PooledEffect
from scenarios.arrays import Array

Settings = dict[str, list[Candidate]]


def look_alikes(
    best: PooledCandidate, tried: Sequence[PooledCandidate], policy: Policy, *, coloured: bool
) -> tuple[list[PooledCandidate], list[PooledCandidate]]:
    """Return candidates as good as the best or of its family, the best first, and look-alikes in coloured noise."""
    explained = [rival for rival in tried if rival is not best and best.explains(rival.columns)]
    family_share = policy.same_family_coloured if coloured else policy.same_family

    def within(rival: PooledCandidate, share: float) -> bool:
        return best.gain - rival.gain < max(best.indistinct_nats, share * best.gain)

    closest = [rival for rival in explained if within(rival, family_share if in_same_family(rival, best) else 0.0)]
    return [best, *closest], [rival for rival in explained if coloured and within(rival, policy.same_coloured)]


def fit_equally_well(effect: PooledEffect, settings: Settings, problems: Sequence[LinearProblem]) -> list[str]:
    """Names of candidates fitting as well as the best where present, on all data, and adding nothing to the best.

    Losses of many columns on held-out data, and prices of searches, guard against false names, not against look-alikes.
    A candidate containing the best always fits as well; it is listed where it gains more than chance.
    """
    best, listed = effect.pooled, [candidate for several in settings.values() for candidate in several]
    others = [candidate for candidate in listed if candidate.name != best.name]
    rows = {i: best.here[i].baseline.rows for i in effect.shown}
    gains = _fitted_gains(effect, [best.candidate, *others], problems)

    def is_close(candidate: Candidate) -> bool:
        more = best.indistinct_nats * (1 if best.name in candidate.effect.traits.contains else -1)
        return candidate in gains and gains[candidate] > gains[best.candidate] + more

    def columns(candidate: Candidate) -> dict[int, Array]:
        return {i: rows[i].bin(candidate.columns(problems[i])) for i in rows}

    close = (candidate.name for candidate in others if is_close(candidate) and best.explains(columns(candidate)))
    return list(dict.fromkeys(close))


def _fitted_gains(
    effect: PooledEffect, candidates: Sequence[Candidate], problems: Sequence[LinearProblem]
) -> dict[Candidate, float]:
    """Nats explained in sample, with the effect's noise models, by candidates that all recordings with the effect hold.

    One coefficient vector for all recordings, or one for each where the effect's coefficients differ.
    """
    tests = {i: effect.pooled.here[i] for i in effect.shown}
    found = [
        estimates_beside(candidates, problems[i], one.baseline, one.hypothesis.noise_model) for i, one in tests.items()
    ]
    several = {one: [each[one] for each in found] for one in candidates if all(one in each for each in found)}
    own = effect.transfer is Transfer.NOT_TRANSFERRED
    return {
        candidate: sum(one.gain(one.c) for one in (estimates if own else [pool_estimates(estimates)]))
        for candidate, estimates in several.items()
    }
