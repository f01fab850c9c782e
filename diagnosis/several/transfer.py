"""Transfer of an effect between recordings: equal in all, of differing size, in some, or in a single one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from diagnosis.policy import Policy
from diagnosis.result import Transfer
from diagnosis.several.coefficients import Agreement, agreement, predicted_by_others
from diagnosis.several.pooled_test import PooledCandidate


class Presence(StrEnum):
    """Presence of an effect in one recording."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "cannot tell"
    NOT_RECORDED = "causes not recorded"


@dataclass(frozen=True)
class TransferFinding:
    """Transfer of an effect in the pool (None: not accepted), nats, presence in each recording, test of agreement.

    nats: over the inflation, of coefficients predicted by the other recordings if `transfer` is not None. agreement:
    pooled coefficients of the recordings with the effect, and their agreement.
    """

    pooled: PooledCandidate
    transfer: Transfer | None
    nats: float
    presence: tuple[Presence, ...]
    agreement: Agreement


def assess_transfer(
    pooled: PooledCandidate, needed: float, policy: Policy, named: Sequence[int] = ()
) -> TransferFinding:
    """Assess the transfer of an effect; needed : nats of predicted coefficients for acceptance.

    An effect whose size differs between recordings is accepted where the predicted size still explains more than
    nothing, or where two recordings name the effect by themselves, as a tone of random phase. named : the recordings
    whose own diagnosis names the effect.
    """
    testable, presence, present = _present_in(pooled, policy)
    gains, agree = _common_nats(pooled, testable, policy)
    total = _total_nats(pooled, gains)
    if _is_supported(pooled, gains, agree, needed) and agree.p > policy.not_transferred_alarm:
        return TransferFinding(pooled, Transfer.TRANSFERRED, total, presence, agree)
    if len(present) < 2:
        return TransferFinding(pooled, None, total, presence, agree)
    gains_present, agree_present = _common_nats(pooled, present, policy)
    part = _total_nats(pooled, gains_present)
    transfer, nats = None, max(total, part)
    if _is_supported(pooled, gains_present if part > total else gains, agree_present, needed):
        same = Presence.ABSENT in presence and part > needed and agree_present.p > policy.not_transferred_alarm
        transfer = Transfer.SOME if same else _differing_transfer(pooled, present, needed)
    elif alone := _independent_nats(pooled, set(present).intersection(named), needed):
        transfer, nats = Transfer.NOT_TRANSFERRED, alone
    return TransferFinding(pooled, transfer, nats, presence, agree_present)


def _differing_transfer(pooled: PooledCandidate, present: Sequence[int], needed: float) -> Transfer | None:
    return Transfer.NOT_TRANSFERRED if _two_support(pooled, present, needed) else None


def _independent_nats(pooled: PooledCandidate, which: Iterable[int], needed: float) -> float:
    """Nats of the own coefficients of recordings showing an effect by themselves; zero for fewer than two."""
    gains = [own for i in which if (own := pooled.own_nats(i)) > needed]
    return sum(gains) if len(gains) > 1 else 0.0


def _two_support(pooled: PooledCandidate, present: Sequence[int], needed: float) -> bool:
    """Whether two recordings support an effect of differing size: by themselves, or in the predicted direction.

    In the second case the predicted coefficients times a positive factor explain each recording: an opposite sign is no
    support, nor is a wander in the predicted direction by chance.
    """
    estimates = {i: estimate for i in present if (estimate := pooled.estimates[i]) is not None}
    gains = (
        estimate.scaled_gain(c)
        for estimate, c in zip(estimates.values(), predicted_by_others(list(estimates.values())), strict=True)
    )
    return sum(max(gain, pooled.own_nats(i)) > needed for i, gain in zip(estimates, gains, strict=True)) > 1


def compare_sensors(pooled: PooledCandidate, policy: Policy) -> TransferFinding:
    """Assess the transfer between the sensors of an array of an effect named by one; None if a single sensor shows it.

    Coefficients are those of the sensors with the effect, and no more certain than one sensor's: all sensors share the
    slow errors of the run.
    """
    testable, presence, present = _present_in(pooled, policy)
    present = present or testable
    gains, agree = _common_nats(pooled, present, policy)
    nats, agree = _total_nats(pooled, gains), replace(agree, covariance=len(present) * agree.covariance)
    if len(present) < 2:
        transfer = None
    elif agree.p <= policy.not_transferred_alarm:
        transfer = Transfer.NOT_TRANSFERRED
    else:
        transfer = Transfer.TRANSFERRED if len(present) == len(pooled.in_recordings) else Transfer.SOME
    return TransferFinding(pooled, transfer, nats, presence, agree)


def predicts(pooled: PooledCandidate, policy: Policy) -> bool:
    """Whether coefficients of a first recording explain a second, whose own coefficients agree."""
    first, second = pooled.estimates
    if first is None or second is None or pooled.nats(1, first.c) <= policy.apart:
        return False
    return agreement([first, second], policy.same_coefficient, pooled.error_degrees).p > policy.not_transferred_alarm


def _present_in(pooled: PooledCandidate, policy: Policy) -> tuple[list[int], tuple[Presence, ...], list[int]]:
    """Recordings with the causes, presence in each, and recordings showing the effect."""
    testable = [i for i, in_recording in enumerate(pooled.in_recordings) if in_recording is not None]
    presence = _presences(pooled, testable, policy)
    return testable, presence, [i for i in testable if presence[i] is Presence.PRESENT]


def _is_supported(pooled: PooledCandidate, gains: Sequence[float], agree: Agreement, needed: float) -> bool:
    """Whether common coefficients explain enough, in more than one recording, and lie within the effect's bounds.

    In a strong recording a tenth of the correct size, predicted by chance, explains a fifth. Without the strongest
    recording, one recording's part of the whole is needed.
    """
    others = sum(gains) - max(gains, default=0.0)
    borne_out = _total_nats(pooled, gains) > needed and others * len(gains) > needed
    return borne_out and pooled.candidate.within_bounds(agree.c)


def _total_nats(pooled: PooledCandidate, gains: Sequence[float]) -> float:
    return sum(gains) - pooled.price


def _common_nats(pooled: PooledCandidate, indices: Sequence[int], policy: Policy) -> tuple[list[float], Agreement]:
    """Nats explained in each recording by coefficients of the others, and the test of agreement."""
    estimates_by_index = {i: estimate for i in indices if (estimate := pooled.estimates[i]) is not None}
    estimates = list(estimates_by_index.values())
    gains = [pooled.nats(i, c) for i, c in zip(estimates_by_index, predicted_by_others(estimates), strict=True)]
    return gains, agreement(estimates, policy.same_coefficient, pooled.error_degrees)


def _presences(pooled: PooledCandidate, testable: Sequence[int], policy: Policy) -> tuple[Presence, ...]:
    """Presence in each recording, by own coefficients or by those of the others with the effect."""
    strong = [i for i in testable if pooled.own_nats(i) > policy.apart] or list(testable)
    return tuple(_presence(pooled, i, [j for j in strong if j != i], policy) for i in range(len(pooled.in_recordings)))


def _presence(pooled: PooledCandidate, i: int, others: Sequence[int], policy: Policy) -> Presence:
    estimate = pooled.estimates[i]
    if estimate is None:
        return Presence.NOT_RECORDED
    if pooled.own_nats(i) > policy.apart and pooled.candidate.within_bounds(estimate.c):
        return Presence.PRESENT
    known = [another for j in others if (another := pooled.estimates[j]) is not None]
    c = agreement(known, 0.0).c if known else 0.0 * estimate.c
    gain = estimate.gain(c) / estimate.inflation(c)
    if gain > policy.apart:
        return Presence.PRESENT
    return Presence.ABSENT if gain < -policy.apart else Presence.UNDECIDED
