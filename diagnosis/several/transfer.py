"""How far an effect reaches: in all recordings with one coefficient, in all with several, in some, or in one alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from diagnosis.policy import Policy
from diagnosis.result import Transfer
from diagnosis.several.coefficients import Agreement, agreement, foretold
from diagnosis.several.pooled_test import PooledCandidate


class There(StrEnum):
    """What one recording says of an effect."""

    PRESENT = "present"
    ABSENT = "absent"
    OPEN = "cannot tell"
    UNASKED = "causes not recorded"


@dataclass(frozen=True)
class TransferFinding:
    """An effect in the lot: how far it reaches (None: no name), nats, what each recording says, and the test.

    nats: over the inflation; of coefficients that the other recordings give where `reach` is not None. agreement: the
    pooled coefficients of those that have it, and whether all of them agree.
    """

    joint: PooledCandidate
    reach: Transfer | None
    nats: float
    there: tuple[There, ...]
    agreement: Agreement


def finding(joint: PooledCandidate, needed: float, policy: Policy, named: Sequence[int] = ()) -> TransferFinding:
    """How far an effect reaches; needed : nats of the others' coefficients above which it is believed.

    Of another size from recording to recording it is believed too, as long as the others' size explains more than none;
    whatever the others' explain where two recordings name it by themselves, as a tone whose phase is another in every
    run. named : the recordings whose own diagnosis names it.
    """
    everyone, there, some = _those_that_show(joint, policy)
    each, agree = _common(joint, everyone, policy)
    total = _total(joint, each)
    if _holds(joint, each, agree, needed) and agree.p > policy.not_transferred_alarm:
        return TransferFinding(joint, Transfer.TRANSFERRED, total, there, agree)
    if len(some) < 2:
        return TransferFinding(joint, None, total, there, agree)
    each_there, agree_there = _common(joint, some, policy)
    part = _total(joint, each_there)
    reach, nats = None, max(total, part)
    if _holds(joint, each_there if part > total else each, agree_there, needed):
        same = There.ABSENT in there and part > needed and agree_there.p > policy.not_transferred_alarm
        reach = Transfer.SOME if same else _differing(joint, some, needed)
    elif alone := _nats_of_each(joint, set(some).intersection(named), needed):
        reach, nats = Transfer.NOT_TRANSFERRED, alone
    return TransferFinding(joint, reach, nats, there, agree_there)


def _differing(joint: PooledCandidate, some: Sequence[int], needed: float) -> Transfer | None:
    return Transfer.NOT_TRANSFERRED if _shown_by_two(joint, some, needed) else None


def _nats_of_each(joint: PooledCandidate, which: Iterable[int], needed: float) -> float:
    """Nats of the own coefficients of recordings that show an effect by themselves; zero unless two do."""
    each = [own for i in which if (own := joint.own(i)) > needed]
    return sum(each) if len(each) > 1 else 0.0


def _shown_by_two(joint: PooledCandidate, some: Sequence[int], needed: float) -> bool:
    """Whether two recordings show an effect whose coefficients differ: by themselves, or in the others' direction.

    The others' coefficients then explain as much of each, times a factor of its own: what has another sign is no second
    witness, nor is a wander that happens to go that way.
    """
    there = {i: one for i in some if (one := joint.estimates[i]) is not None}
    gains = (one.scaled_gain(c) for one, c in zip(there.values(), foretold(list(there.values())), strict=True))
    return sum(max(gain, joint.own(i)) > needed for i, gain in zip(there, gains, strict=True)) > 1


def compared(joint: PooledCandidate, policy: Policy) -> TransferFinding:
    """How far an effect that one sensor of an array names reaches among all: None where one alone shows it.

    Its coefficients are those of the sensors that have it, whatever the others say of them; known no better than by one
    of these, for the slow errors of a run are in all of its sensors.
    """
    everyone, there, some = _those_that_show(joint, policy)
    some = some or everyone
    each, agree = _common(joint, some, policy)
    nats, agree = _total(joint, each), replace(agree, covariance=len(some) * agree.covariance)
    if len(some) < 2:
        reach = None
    elif agree.p <= policy.not_transferred_alarm:
        reach = Transfer.NOT_TRANSFERRED
    else:
        reach = Transfer.TRANSFERRED if len(some) == len(joint.asked) else Transfer.SOME
    return TransferFinding(joint, reach, nats, there, agree)


def foretells(joint: PooledCandidate, policy: Policy) -> bool:
    """Whether a first recording's coefficients, as they are, explain a second, whose own agree with them."""
    first, second = joint.estimates
    if first is None or second is None or joint.nats(1, first.c) <= policy.apart:
        return False
    return agreement([first, second], policy.same_coefficient, joint.known).p > policy.not_transferred_alarm


def _those_that_show(joint: PooledCandidate, policy: Policy) -> tuple[list[int], tuple[There, ...], list[int]]:
    """Recordings that hold the causes, what each says, and those that show the effect."""
    everyone = [i for i, one in enumerate(joint.asked) if one is not None]
    there = _there(joint, everyone, policy)
    return everyone, there, [i for i in everyone if there[i] is There.PRESENT]


def _holds(joint: PooledCandidate, each: Sequence[float], agree: Agreement, needed: float) -> bool:
    """Whether common coefficients explain enough, not in one recording alone, and are such as the effect can have.

    Of a recording that shows an effect strongly a tenth of the right size, which others may give by chance, explains a
    fifth: without it as much is needed as one recording's part of the whole.
    """
    others = sum(each) - max(each, default=0.0)
    borne_out = _total(joint, each) > needed and others * len(each) > needed
    return borne_out and joint.candidate.possible(agree.c)


def _total(joint: PooledCandidate, each: Sequence[float]) -> float:
    return sum(each) - joint.price


def _common(joint: PooledCandidate, which: Sequence[int], policy: Policy) -> tuple[list[float], Agreement]:
    """Nats that in each of some recordings the coefficients of the others explain, and whether they agree."""
    there = {i: one for i in which if (one := joint.estimates[i]) is not None}
    estimates = list(there.values())
    each = [joint.nats(i, c) for i, c in zip(there, foretold(estimates), strict=True)]
    return each, agreement(estimates, policy.same_coefficient, joint.known)


def _there(joint: PooledCandidate, everyone: Sequence[int], policy: Policy) -> tuple[There, ...]:
    """What each recording says: by its own coefficients, or by those of the others that have the effect."""
    strong = [i for i in everyone if joint.own(i) > policy.apart] or list(everyone)
    return tuple(_one(joint, i, [j for j in strong if j != i], policy) for i in range(len(joint.asked)))


def _one(joint: PooledCandidate, i: int, others: Sequence[int], policy: Policy) -> There:
    one = joint.estimates[i]
    if one is None:
        return There.UNASKED
    if joint.own(i) > policy.apart and joint.candidate.possible(one.c):
        return There.PRESENT
    known = [other for j in others if (other := joint.estimates[j]) is not None]
    c = agreement(known, 0.0).c if known else 0.0 * one.c
    gain = one.gain(c) / one.inflation(c)
    if gain > policy.apart:
        return There.PRESENT
    return There.ABSENT if gain < -policy.apart else There.OPEN
