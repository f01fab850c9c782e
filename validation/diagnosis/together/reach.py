"""How far an effect reaches: in all recordings with one coefficient, in all with several, in some, or in one alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from sim.state import Array
from validation.diagnosis.policy import Policy
from validation.diagnosis.result import Reach
from validation.diagnosis.together.asked import Asked, Joint
from validation.diagnosis.together.coefficients import Agreement, agreement, left_out_gains


class There(StrEnum):
    """What one recording says of an effect."""

    PRESENT = "present"
    ABSENT = "absent"
    OPEN = "cannot tell"
    UNASKED = "causes not recorded"


@dataclass(frozen=True)
class Finding:
    """An effect in the lot: how far it reaches (None: no name), nats, what each recording says, and the test.

    nats: over the inflation; of coefficients that the other recordings give where `reach` is not None. agreement: the
    pooled coefficients of those that have it, and whether all of them agree.
    """

    joint: Joint
    reach: Reach | None
    nats: float
    there: tuple[There, ...]
    agreement: Agreement


def finding(joint: Joint, named_by: Sequence[bool], needed: float, policy: Policy) -> Finding:
    """How far an effect reaches.

    named_by (n,): whether each recording's own diagnosis names it. needed : nats above which the lot believes it.
    """
    everyone = [i for i, one in enumerate(joint.asked) if one is not None]
    there = _there(joint, everyone, policy)
    some = [i for i in everyone if there[i] is There.PRESENT]
    total, agree = _common(joint, everyone, policy)
    if _holds(total, agree, needed, policy):
        return Finding(joint, Reach.TRANSFERRED, total, there, agree)
    if len(some) < 2:
        return Finding(joint, None, total, there, agree)
    part, agree_there = _common(joint, some, policy)
    if There.ABSENT in there and _holds(part, agree_there, needed, policy):
        return Finding(joint, Reach.SOME, part, there, agree_there)
    seen = max(total, part) > needed or _named_by_several(joint, some, named_by, needed)
    nats = max(part, sum(_own(joint.asked[i]) for i in some))
    return Finding(joint, Reach.NOT_TRANSFERRED if seen else None, nats, there, agree_there)


def _holds(nats: float, agree: Agreement, needed: float, policy: Policy) -> bool:
    """Whether common coefficients explain enough, and are common."""
    return nats > needed and agree.p > policy.not_transferred_alarm


def _named_by_several(joint: Joint, some: Sequence[int], named_by: Sequence[bool], needed: float) -> bool:
    """Whether more than one recording's own diagnosis names it on as much evidence as the lot needs."""
    return sum(named_by[i] and _own(joint.asked[i]) > needed for i in some) > 1


def _own(one: Asked | None) -> float:
    """Nats on held-out folds of a recording's own coefficients."""
    return 0.0 if one is None else one.held / one.inflation


def _common(joint: Joint, which: Sequence[int], policy: Policy) -> tuple[float, Agreement]:
    """Nats that in each of some recordings the coefficients of the others explain, and whether they agree."""
    some = [one for i in which if (one := joint.asked[i]) is not None]
    estimates = [one.estimate for one in some]
    gains = left_out_gains(estimates) - np.array([one.without / one.inflation for one in some])
    return float(gains.sum()) - joint.price, agreement(estimates, policy.same_coefficient)


def _there(joint: Joint, everyone: Sequence[int], policy: Policy) -> tuple[There, ...]:
    """What each recording says: by its own coefficients, or by those of the others that have the effect."""
    strong = [i for i in everyone if _own(joint.asked[i]) > policy.apart] or list(everyone)
    return tuple(_one(joint, i, [j for j in strong if j != i], policy) for i in range(len(joint.asked)))


def _one(joint: Joint, i: int, others: Sequence[int], policy: Policy) -> There:
    one = joint.asked[i]
    if one is None:
        return There.UNASKED
    if _own(one) > policy.apart:
        return There.PRESENT
    c = _pooled([other for j in others if (other := joint.asked[j]) is not None])
    gain = 0.0 if c is None else one.estimate.gain(c)
    if gain > policy.apart:
        return There.PRESENT
    return There.ABSENT if gain < -policy.apart else There.OPEN


def _pooled(others: Sequence[Asked]) -> Array | None:
    return agreement([one.estimate for one in others], 0.0).c if others else None
