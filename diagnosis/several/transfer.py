"""An effect in several recordings: equal in all, of differing size, in some, or in a single one; look-alikes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from diagnosis.decision.choice import in_same_family
from diagnosis.library.candidates import Candidate
from diagnosis.result import Transfer
from diagnosis.several.coefficients import (
    Agreement,
    CoefficientEstimate,
    agreement,
    pool_estimates,
    predicted_by_others,
)
from diagnosis.several.pooled_test import PooledCandidate, estimates_of
from validation.signals.amplitude import rms

Settings = dict[str, list[Candidate]]
"""Settings of each effect by name."""


class Presence(StrEnum):
    """Presence of an effect in one recording."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "cannot tell"
    NOT_RECORDED = "causes not recorded"


@dataclass(frozen=True)
class PooledEffect:
    """An effect in the pool: transfer (None: not accepted), nats, presence, agreement, look-alikes.

    nats: over the inflation, of coefficients predicted by the other recordings if `transfer` is not None. presence: in
    the recordings that hold the causes. agreement: pooled coefficients of the recordings with the effect.
    """

    pooled: PooledCandidate
    transfer: Transfer | None
    nats: float
    presence: Mapping[int, Presence]
    agreement: Agreement
    alternatives: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.pooled.name

    @property
    def present(self) -> list[int]:
        """Indices of the recordings that show the effect."""
        return [i for i, presence in self.presence.items() if presence is Presence.PRESENT]

    @property
    def shown(self) -> list[int]:
        """Indices of the recordings that show the effect; of all with its causes where together they alone show it."""
        return self.present or list(self.presence)

    @property
    def possible(self) -> dict[int, CoefficientEstimate]:
        """Coefficients in the recordings that hold the causes and do not exclude the effect."""
        return {i: one for i, one in self.pooled.estimates.items() if self.presence[i] is not Presence.ABSENT}

    @property
    def agrees(self) -> bool:
        """Whether the coefficients of the recordings with the effect agree."""
        return self.agreement.p > self.pooled.policy.not_transferred_alarm

    @cached_property
    def strength(self) -> float:
        """Rms over the recordings with the effect, in units of the noise of each."""
        return rms(np.array([self.pooled.here[i].strength for i in self.shown]))


def assess_transfer(pooled: PooledCandidate, needed: float, named: Sequence[int] = ()) -> PooledEffect:
    """Assess the transfer of an effect; needed : nats of predicted coefficients for acceptance.

    An effect whose size differs between recordings is accepted where two of them show the effect by themselves, and the
    predicted size still explains more than nothing, or both name the effect, as a tone of random phase. named : the
    recordings whose own diagnosis names the effect.
    """
    gains, agree = _common_nats(pooled, pooled.here)
    effect = PooledEffect(pooled, None, sum(gains) - pooled.price, _presences(pooled), agree)
    if _is_supported(pooled, gains, agree, needed) and effect.agrees:
        return replace(effect, transfer=Transfer.TRANSFERRED)
    return effect if len(effect.present) < 2 else _differing(effect, gains, needed, named)


def _differing(effect: PooledEffect, gains: Sequence[float], needed: float, named: Sequence[int]) -> PooledEffect:
    """The transfer between the recordings that show an effect, whose coefficients do not explain all recordings.

    gains : nats in each recording of the coefficients of all others.
    """
    pooled = effect.pooled
    gains_present, agree = _common_nats(pooled, effect.present)
    best, part = max(gains, gains_present, key=sum), sum(gains_present) - pooled.price
    effect = replace(effect, nats=sum(best) - pooled.price, agreement=agree)
    supported = _is_supported(pooled, best, agree, needed)
    if supported and effect.agrees and part > needed and Presence.ABSENT in effect.presence.values():
        return replace(effect, transfer=Transfer.SOME)
    alone = [own for i in effect.present if (supported or i in named) and (own := pooled.own_nats(i)) > needed]
    if len(alone) < 2:
        return effect
    return replace(effect, transfer=Transfer.NOT_TRANSFERRED, nats=effect.nats if supported else sum(alone))


def compare_sensors(pooled: PooledCandidate) -> PooledEffect:
    """Assess the transfer between the sensors of an array of an effect named by one; None if a single sensor shows it.

    Coefficients are those of the sensors with the effect, and no more certain than one sensor's: all sensors share the
    slow errors of the run.
    """
    presence = _presences(pooled)
    present = [i for i in pooled.here if presence[i] is Presence.PRESENT] or list(pooled.here)
    gains, agree = _common_nats(pooled, present)
    transfer = transfer_of(agree.p > pooled.policy.not_transferred_alarm, len(present), len(presence))
    agree = replace(agree, covariance=len(present) * agree.covariance)
    return PooledEffect(pooled, transfer if len(present) > 1 else None, sum(gains) - pooled.price, presence, agree)


def transfer_of(agrees: bool, showing: int, of: int) -> Transfer:
    """How far an effect seen in some recordings transfers, given whether its sizes agree."""
    if not agrees:
        return Transfer.NOT_TRANSFERRED
    return Transfer.TRANSFERRED if showing == of else Transfer.SOME


def predicts(pooled: PooledCandidate) -> bool:
    """Whether coefficients of a first recording explain a second, whose own coefficients agree."""
    if len(pooled.here) < 2:
        return False
    (_, gain), agree = _common_nats(pooled, pooled.here)
    return gain > pooled.policy.apart and agree.p > pooled.policy.not_transferred_alarm


def _is_supported(pooled: PooledCandidate, gains: Sequence[float], agree: Agreement, needed: float) -> bool:
    """Whether common coefficients explain enough, in more than one recording, and lie within the effect's bounds.

    In a strong recording a tenth of the correct size, predicted by chance, explains a fifth. Without the strongest
    recording, one recording's part of the whole is needed.
    """
    others = sum(gains) - max(gains, default=0.0)
    borne_out = sum(gains) - pooled.price > needed and others * len(gains) > needed
    return borne_out and pooled.candidate.within_bounds(agree.c)


def _common_nats(pooled: PooledCandidate, which: Iterable[int]) -> tuple[list[float], Agreement]:
    """Nats explained in each recording by coefficients of the others, and the test of agreement."""
    estimates, form = {i: pooled.estimates[i] for i in which}, pooled.policy.same_coefficient
    gains = [pooled.nats(i, c) for i, c in predicted_by_others(estimates).items()]
    return gains, agreement(list(estimates.values()), form, pooled.error_degrees)


def _presences(pooled: PooledCandidate) -> dict[int, Presence]:
    """Presence in each recording, by own coefficients or by those of the others with the effect."""
    apart, found = pooled.policy.apart, {}
    strong = [i for i in pooled.here if pooled.own_nats(i) > apart] or list(pooled.here)
    for i, estimate in pooled.estimates.items():
        c = predicted_by_others({j: pooled.estimates[j] for j in {i, *strong}})[i]
        gain = estimate.gain(c) / estimate.inflation(c)
        shows_alone = pooled.own_nats(i) > apart and pooled.candidate.within_bounds(estimate.c)
        if shows_alone or gain > apart:
            found[i] = Presence.PRESENT
        else:
            found[i] = Presence.ABSENT if gain < -apart else Presence.UNDECIDED
    return found


def look_alikes(
    best: PooledCandidate, tried: Sequence[PooledCandidate], *, coloured: bool
) -> tuple[list[PooledCandidate], list[PooledCandidate]]:
    """Return candidates as good as the best or of its family, the best first, and look-alikes in coloured noise."""
    policy, explained = best.policy, [one for one in tried if one is not best and best.explains(one.columns)]
    family_share = policy.same_family_coloured if coloured else policy.same_family

    def within(rival: PooledCandidate, share: float) -> bool:
        return best.gain - rival.gain < max(best.indistinct_nats, share * best.gain)

    closest = [rival for rival in explained if within(rival, family_share if in_same_family(rival, best) else 0.0)]
    return [best, *closest], [rival for rival in explained if coloured and within(rival, policy.same_coloured)]


def fit_equally_well(effect: PooledEffect, settings: Settings) -> list[str]:
    """Names of candidates fitting as well as the best where present, on all data, and adding nothing to the best.

    Losses of many columns on held-out data, and prices of searches, guard against false names, not against look-alikes.
    A candidate containing the best always fits as well; it is listed where it gains more than chance.
    """
    best, tests = effect.pooled, {i: effect.pooled.here[i] for i in effect.shown}
    others = [candidate for listed in settings.values() for candidate in listed if candidate.name != best.name]
    gains, close = _fitted_gains(effect, [best.candidate, *others]), dict[str, None]()
    for candidate in others:
        more = best.indistinct_nats * (1 if best.name in candidate.effect.traits.contains else -1)
        if gains.get(candidate, -np.inf) > gains[best.candidate] + more:
            columns = {i: one.baseline.rows.bin(candidate.columns(one.problem)) for i, one in tests.items()}
            close |= {candidate.name: None} if best.explains(columns) else {}
    return list(close)


def _fitted_gains(effect: PooledEffect, candidates: Sequence[Candidate]) -> dict[Candidate, float]:
    """Nats explained in sample, with the effect's noise models, by candidates that all recordings with the effect hold.

    One coefficient vector for all recordings, or one for each where the effect's coefficients differ.
    """
    posed, own = [effect.pooled.here[i].posed for i in effect.shown], effect.transfer is Transfer.NOT_TRANSFERRED
    return {
        candidate: sum(one.gain(one.c) for one in (estimates if own else [pool_estimates(estimates)]))
        for candidate, estimates in estimates_of(candidates, posed).items()
        if len(estimates) == len(posed)
    }
