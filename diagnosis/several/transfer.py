"""Transfer of an effect between recordings: equal in all, of differing size, in some, or in a single one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from diagnosis.policy import Policy
from diagnosis.result import Transfer
from diagnosis.several.coefficients import Agreement, CoefficientEstimate, agreement, predicted_by_others
from diagnosis.several.pooled_test import PooledCandidate
from validation.signals.amplitude import rms


class Presence(StrEnum):
    """Presence of an effect in one recording."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "cannot tell"
    NOT_RECORDED = "causes not recorded"


@dataclass(frozen=True)
class PooledEffect:
    """An effect in the pool: transfer (None: not accepted), nats, presence in each recording, agreement, look-alikes.

    nats: over the inflation, of coefficients predicted by the other recordings if `transfer` is not None. agreement:
    pooled coefficients of the recordings with the effect, and their agreement.
    """

    pooled: PooledCandidate
    transfer: Transfer | None
    nats: float
    presence: tuple[Presence, ...]
    agreement: Agreement
    alternatives: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.pooled.name

    @property
    def present(self) -> list[int]:
        """Indices of the recordings that show the effect."""
        return [i for i in self.pooled.here if self.presence[i] is Presence.PRESENT]

    @property
    def shown(self) -> list[int]:
        """Indices of the recordings that show the effect; of all with its causes where together they alone show it."""
        return self.present or list(self.pooled.here)

    @property
    def possible(self) -> dict[int, CoefficientEstimate]:
        """Coefficients in the recordings that hold the causes and do not exclude the effect."""
        return {i: one for i, one in self.pooled.estimates.items() if self.presence[i] is not Presence.ABSENT}

    @property
    def strength(self) -> float:
        """Rms over the recordings with the effect, in units of the noise of each."""
        return rms(np.array([self.pooled.here[i].strength for i in self.shown]))


def assess_transfer(pooled: PooledCandidate, needed: float, policy: Policy, named: Sequence[int] = ()) -> PooledEffect:
    """Assess the transfer of an effect; needed : nats of predicted coefficients for acceptance.

    An effect whose size differs between recordings is accepted where two of them show the effect by themselves, and the
    predicted size still explains more than nothing, or both name the effect, as a tone of random phase. named : the
    recordings whose own diagnosis names the effect.
    """
    presence = _presences(pooled, policy)
    gains, agree = _common_nats(pooled, pooled.here, policy)
    effect = PooledEffect(pooled, None, sum(gains) - pooled.price, presence, agree)
    if _is_supported(pooled, gains, agree, needed) and agree.p > policy.not_transferred_alarm:
        return replace(effect, transfer=Transfer.TRANSFERRED)
    return effect if len(effect.present) < 2 else _differing(effect, gains, needed, policy, named)


def _differing(
    effect: PooledEffect, gains: Sequence[float], needed: float, policy: Policy, named: Sequence[int]
) -> PooledEffect:
    """The transfer between the recordings that show an effect, whose coefficients do not explain all recordings.

    gains : nats in each recording of the coefficients of all others.
    """
    pooled = effect.pooled
    gains_present, agree = _common_nats(pooled, effect.present, policy)
    best, part = max(gains, gains_present, key=sum), sum(gains_present) - pooled.price
    effect = replace(effect, nats=sum(best) - pooled.price, agreement=agree)
    supported, agrees = _is_supported(pooled, best, agree, needed), agree.p > policy.not_transferred_alarm
    if supported and agrees and part > needed and Presence.ABSENT in effect.presence:
        return replace(effect, transfer=Transfer.SOME)
    nats = [pooled.own_nats(i) for i in effect.present if supported or i in named]
    alone = [own for own in nats if own > needed]
    if len(alone) < 2:
        return effect
    return replace(effect, transfer=Transfer.NOT_TRANSFERRED, nats=effect.nats if supported else sum(alone))


def compare_sensors(pooled: PooledCandidate, policy: Policy) -> PooledEffect:
    """Assess the transfer between the sensors of an array of an effect named by one; None if a single sensor shows it.

    Coefficients are those of the sensors with the effect, and no more certain than one sensor's: all sensors share the
    slow errors of the run.
    """
    presence = _presences(pooled, policy)
    present = [i for i in pooled.here if presence[i] is Presence.PRESENT] or list(pooled.here)
    gains, agree = _common_nats(pooled, present, policy)
    transfer = transfer_of(agree.p > policy.not_transferred_alarm, len(present), len(presence))
    agree = replace(agree, covariance=len(present) * agree.covariance)
    return PooledEffect(pooled, transfer if len(present) > 1 else None, sum(gains) - pooled.price, presence, agree)


def transfer_of(agrees: bool, showing: int, of: int) -> Transfer:
    """How far an effect seen in some recordings transfers, given whether its sizes agree."""
    if not agrees:
        return Transfer.NOT_TRANSFERRED
    return Transfer.TRANSFERRED if showing == of else Transfer.SOME


def predicts(pooled: PooledCandidate, policy: Policy) -> bool:
    """Whether coefficients of a first recording explain a second, whose own coefficients agree."""
    if len(pooled.here) < 2 or pooled.nats(1, pooled.estimates[0].c) <= policy.apart:
        return False
    return _agreement(pooled, pooled.here, policy).p > policy.not_transferred_alarm


def _is_supported(pooled: PooledCandidate, gains: Sequence[float], agree: Agreement, needed: float) -> bool:
    """Whether common coefficients explain enough, in more than one recording, and lie within the effect's bounds.

    In a strong recording a tenth of the correct size, predicted by chance, explains a fifth. Without the strongest
    recording, one recording's part of the whole is needed.
    """
    others = sum(gains) - max(gains, default=0.0)
    borne_out = sum(gains) - pooled.price > needed and others * len(gains) > needed
    return borne_out and pooled.candidate.within_bounds(agree.c)


def _common_nats(pooled: PooledCandidate, which: Iterable[int], policy: Policy) -> tuple[list[float], Agreement]:
    """Nats explained in each recording by coefficients of the others, and the test of agreement."""
    predicted = predicted_by_others({i: pooled.estimates[i] for i in which})
    return [pooled.nats(i, c) for i, c in predicted.items()], _agreement(pooled, predicted, policy)


def _agreement(pooled: PooledCandidate, which: Iterable[int], policy: Policy) -> Agreement:
    return agreement([pooled.estimates[i] for i in which], policy.same_coefficient, pooled.error_degrees)


def _presences(pooled: PooledCandidate, policy: Policy) -> tuple[Presence, ...]:
    """Presence in each recording, by own coefficients or by those of the others with the effect."""
    strong = [i for i in pooled.here if pooled.own_nats(i) > policy.apart] or list(pooled.here)
    return tuple(_presence(pooled, i, [j for j in strong if j != i], policy) for i in range(len(pooled.in_recordings)))


def _presence(pooled: PooledCandidate, i: int, others: Sequence[int], policy: Policy) -> Presence:
    if i not in pooled.here:
        return Presence.NOT_RECORDED
    estimate = pooled.estimates[i]
    if pooled.own_nats(i) > policy.apart and pooled.candidate.within_bounds(estimate.c):
        return Presence.PRESENT
    c = predicted_by_others({j: pooled.estimates[j] for j in (i, *others)})[i]
    gain = estimate.gain(c) / estimate.inflation(c)
    if gain > policy.apart:
        return Presence.PRESENT
    return Presence.ABSENT if gain < -policy.apart else Presence.UNDECIDED
