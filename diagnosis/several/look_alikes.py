"""What the recordings together do not tell from an effect that they bear out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.decision.white_choice import are_kin
from diagnosis.evidence.hypothesis import Hypothesis, informations
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate, pooled
from diagnosis.several.pooled_test import PooledCandidate, columns_in, estimate
from diagnosis.several.transfer import There, TransferFinding
from scenarios.arrays import Array

Settings = dict[str, list[Candidate]]


def look_alikes(
    best: PooledCandidate, tried: Sequence[PooledCandidate], policy: Policy, *, coloured: bool
) -> tuple[list[PooledCandidate], list[PooledCandidate]]:
    """Those as good as the best or of its kin, the best first, and others that may be it beside a coloured rest."""
    useless = [one for one in tried if one is not best and is_useless_beside(one.columns, best)]
    kin_share = policy.same_kin_coloured if coloured else policy.same_kin

    def within(one: PooledCandidate, share: float) -> bool:
        return best.gain - one.gain < max(best.chance, share * best.gain)

    closest = [one for one in useless if within(one, kin_share if are_kin(one, best) else 0.0)]
    return [best, *closest], [one for one in useless if coloured and within(one, policy.same_coloured)]


def is_useless_beside(columns: Sequence[Array | None], best: PooledCandidate) -> bool:
    """Whether a rival's columns in each recording keep little of their own gain over all once the best is in."""
    kept = alone = 0.0
    for one, other in zip(columns, best.asked, strict=True):
        if one is None or other is None:
            continue
        beside, rest = other.beside, other.hypothesis.rest
        both = np.concatenate([beside.joined(other.columns), one], axis=2)
        kept += Hypothesis.given(beside.rows, both, rest).held - other.hypothesis.held
        alone += Hypothesis.given(beside.rows, beside.joined(one), rest).held
        alone -= Hypothesis.given(beside.rows, beside.inside, rest).held
    return kept / max(alone, 1e-9) < best.policy.look_alike_left


def explain_as_much(found: TransferFinding, settings: Settings, problems: Sequence[LinearProblem]) -> list[str]:
    """Names that fit as well as the best where it is present, on all data, and are of no use beside it.

    What many columns lose on held-out data and what a search pays for guard a name, but not against its look-alikes.
    One that contains the best always fits as well: it is one of them where it fits better than by chance.
    """
    best = found.joint
    several = [one for each in settings.values() for one in each if one.name != best.name]
    columns = _where_present(found, several, problems)
    gains = _fitted_gains(found, list(columns.values()))
    best_gain = _fitted_gains(found, [best.columns])[0]

    def least(one: Candidate) -> float:
        return best_gain + (best.chance if best.name in one.effect.traits.contains else -best.chance)

    close = [one for one, gain in zip(columns, gains, strict=True) if gain > least(one)]
    return list(dict.fromkeys(one.name for one in close if is_useless_beside(columns[one], best)))


def _where_present(
    found: TransferFinding, several: Sequence[Candidate], problems: Sequence[LinearProblem]
) -> dict[Candidate, list[Array | None]]:
    """Columns (n, q, k) in rows of the recordings that have the effect, of candidates whose causes all these hold."""
    columns: dict[Candidate, list[Array | None]] = {one: [] for one in several}
    for asked, says, problem in zip(found.joint.asked, found.there, problems, strict=True):
        for one in list(columns):
            whole = columns_in(one, problem)
            if asked is None or says is not There.PRESENT:
                columns[one].append(None)
            elif whole is None:
                del columns[one]
            else:
                columns[one].append(asked.beside.rows.taken(whole))
    return columns


def _fitted_gains(found: TransferFinding, several: Sequence[Sequence[Array | None]]) -> list[float]:
    """Nats that groups of columns explain in sample where an effect is present, beside its rests.

    Of one coefficient for all, or where the effect has several of as many.
    """
    each: list[list[CoefficientEstimate]] = [[] for _ in several]
    for i, (asked, says) in enumerate(zip(found.joint.asked, found.there, strict=True)):
        if asked is None or says is not There.PRESENT:
            continue
        rows, inside, rest = asked.beside.rows, asked.beside.inside, asked.hypothesis.rest
        columns = [there for one in several if (there := one[i]) is not None]
        for estimates, one in zip(each, informations(rows, inside, columns, rest), strict=True):
            estimates.append(estimate(one))
    own = found.reach is Transfer.NOT_TRANSFERRED
    return [sum(one.gain(one.c) for one in (some if own else [pooled(some)])) for some in each]
