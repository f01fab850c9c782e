"""Transfer of an effect between recordings: equal in all, of differing size, in some, or in one; confirmation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.advice import advice_for
from diagnosis.decision.choice import is_as_good
from diagnosis.decision.sentence import sentence_for
from diagnosis.evidence.reference_checks import correct_reference
from diagnosis.library.candidates import Candidate
from diagnosis.problem.formulation import pose_model, refit_iron
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import FITTED, Diagnosis, NamedEffect, Transfer
from diagnosis.several.coefficients import Agreement, agreement, pool_estimates, predicted_by_others
from diagnosis.several.pooled_effect import PooledEffect, Presence, columns_in, estimates_of
from diagnosis.workflow import measured_rows
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.scenario import Model

Settings = dict[str, list[Candidate]]
"""Settings of each effect by name."""


@dataclass(frozen=True)
class Forecast:
    """Nats explained in each of several recordings by coefficients of the others, and the test of agreement."""

    effect: PooledEffect
    gains: list[float]
    agreement: Agreement

    @classmethod
    def of(cls, effect: PooledEffect, which: Iterable[int]) -> Forecast:
        """The forecast among recordings by index."""
        estimates = {i: effect.estimates[i] for i in which}
        gains = [effect.predicted_nats(i, c) for i, c in predicted_by_others(estimates).items()]
        form, known = effect.policy.same_coefficient, sum(len(one.parts) - 1 for one in effect.here.values())
        return cls(effect, gains, agreement(list(estimates.values()), form, known))

    @property
    def nats(self) -> float:
        """Nats of all recordings, less the price of the search."""
        return sum(self.gains) - self.effect.price

    @property
    def agrees(self) -> bool:
        """Whether the coefficients of the recordings agree."""
        return self.agreement.p > self.effect.policy.not_transferred_alarm

    def supports(self, needed: float) -> bool:
        """Whether common coefficients explain enough, in more than one recording, and lie within the effect's bounds.

        In a strong recording a tenth of the correct size, predicted by chance, explains a fifth. Without the strongest
        recording, one recording's part of the whole is needed.
        """
        others = sum(self.gains) - max(self.gains, default=0.0)
        borne_out = self.nats > needed and others * len(self.gains) > needed
        return borne_out and self.effect.candidate.within_bounds(self.agreement.c)

    def assessed(self, transfer: Transfer | None) -> PooledEffect:
        """The effect with its transfer, and the nats and agreement of the forecast."""
        return replace(self.effect, transfer=transfer, nats=self.nats, agreement=self.agreement)


def assess_transfer(pooled: PooledEffect, needed: float, named: Sequence[int] = ()) -> PooledEffect:
    """Assess the transfer of an effect; needed : nats of predicted coefficients for acceptance.

    An effect whose size differs between recordings is accepted where two of them show the effect by themselves, and the
    predicted size still explains more than nothing, or both name the effect, as a tone of random phase. named : the
    recordings whose own diagnosis names the effect.
    """
    every = Forecast.of(pooled, pooled.here)
    if every.agrees and every.supports(needed):
        return every.assessed(Transfer.TRANSFERRED)
    return every.assessed(None) if len(pooled.present) < 2 else _differing(every, needed, named)


def _differing(every: Forecast, needed: float, named: Sequence[int]) -> PooledEffect:
    """The transfer of an effect that two recordings show, and whose coefficients do not explain all recordings."""
    pooled, shown = every.effect, Forecast.of(every.effect, every.effect.present)
    best = replace(shown, gains=max(every.gains, shown.gains, key=sum))
    supported = best.supports(needed)
    if supported and shown.agrees and shown.nats > needed and Presence.ABSENT in pooled.presence.values():
        return best.assessed(Transfer.SOME)
    alone = [own for i in pooled.present if (supported or i in named) and (own := pooled.own_nats(i)) > needed]
    if len(alone) < 2:
        return best.assessed(None)
    return replace(best.assessed(Transfer.NOT_TRANSFERRED), nats=best.nats if supported else sum(alone))


def compare_sensors(pooled: PooledEffect) -> PooledEffect:
    """Assess the transfer between the sensors of an array of an effect named by one; None if a single sensor shows it.

    Coefficients are those of the sensors with the effect, and no more certain than one sensor's: all sensors share the
    slow errors of the run.
    """
    n, shown = len(pooled.shown), Forecast.of(pooled, pooled.shown)
    found = shown.assessed(transfer_of(shown.agrees, n, len(pooled.here)) if n > 1 else None)
    return replace(found, agreement=replace(found.agreement, covariance=n * found.agreement.covariance))


def transfer_of(agrees: bool, showing: int, of: int) -> Transfer:
    """How far an effect seen in some recordings transfers, given whether its sizes agree."""
    if not agrees:
        return Transfer.NOT_TRANSFERRED
    return Transfer.TRANSFERRED if showing == of else Transfer.SOME


def confirmed(
    found: Diagnosis, second: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None
) -> Diagnosis:
    """The diagnosis with each effect marked as transferred where the second recording confirms it.

    Each recording has its own iron, its own noise model, and its own estimate of the coefficients. An effect is
    transferred where the coefficients of the first recording explain the second, in nats over the inflation of their
    error, and agree with the estimate of the second. Where only the strength is known, the iron of the second recording
    is fitted with the effects removed. Events of a single run and effects in a window cannot be confirmed.
    """
    whole = pose_model(second, model, field_enu_nT, strength_nT, policy=found.problem.policy)
    throughout = [one for one in found.named if one.kind in FITTED and one.effect.active_s is None]
    effects = [effect for one in throughout for effect in one.effects if not effect.traits.absorbed]
    problems = (found.problem, _without_known(correct_reference(measured_rows(whole)[0]), effects))

    def confirm(one: NamedEffect) -> NamedEffect:
        if not one.transferable or found.problem.mode != problems[1].mode:
            return one
        others = [Candidate.of(effect) for effect in effects if effect is not one.effect]
        holds = predicts(PooledEffect.beside([Candidate.of(one.effect)], others, problems))
        return replace(one, transfer=Transfer.TRANSFERRED) if holds else one

    known = replace(found, named=tuple(confirm(one) for one in found.named), has_second=True)
    return replace(known, sentence=sentence_for(known), advice=advice_for(known))


def _without_known(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """The problem with its iron fitted again after the effects are removed, in strength mode."""
    if problem.mode != "strength" or not effects:
        return problem
    total_nT = np.zeros((len(problem.recording), 3))
    for effect in effects:
        if columns_in(Candidate.of(effect), problem) is not None:
            kind = type(effect)
            part_nT = effect.contribution(problem.state, problem.input_nT(kind), np.random.default_rng(0), {})
            total_nT += part_nT @ problem.matrix_behind(kind).T
    return refit_iron(problem, total_nT)


def predicts(pooled: PooledEffect) -> bool:
    """Whether coefficients of a first recording explain a second, whose own coefficients agree."""
    if len(pooled.here) < 2:
        return False
    forecast = Forecast.of(pooled, pooled.here)
    return forecast.gains[1] > pooled.policy.apart and forecast.agrees


def look_alikes(
    best: PooledEffect, tried: Sequence[PooledEffect], *, coloured: bool
) -> tuple[list[PooledEffect], list[PooledEffect]]:
    """Return candidates as good as the best or of its family, the best first, and look-alikes in coloured noise."""
    policy, explained = best.policy, [one for one in tried if one is not best and best.explains(one.columns)]
    form, near = (policy.same_family_coloured, policy.same_coloured) if coloured else (policy.same_family, 0.0)
    as_good = [best, *(one for one in explained if is_as_good(one, best, policy, form, 0.0))]
    return as_good, [one for one in explained if best.gain - one.gain < near * best.gain]


def fit_equally_well(effect: PooledEffect, settings: Settings) -> list[str]:
    """Names of candidates fitting as well as the best where present, on all data, and adding nothing to the best.

    Losses of many columns on held-out data, and prices of searches, guard against false names, not against look-alikes.
    A candidate containing the best always fits as well; it is listed where it gains more than chance.
    """
    others = [candidate for listed in settings.values() for candidate in listed if candidate.name != effect.name]
    gains, close = _fitted_gains(effect, [effect.candidate, *others]), dict[str, None]()
    for candidate in others:
        more = effect.policy.apart * effect.V * (1 if effect.name in candidate.effect.traits.contains else -1)
        if gains.get(candidate, -np.inf) > gains[effect.candidate] + more:
            columns = {i: effect.here[i].baseline.columns_of(candidate) for i in effect.shown}
            close |= {candidate.name: None} if effect.explains(columns) else {}
    return list(close)


def _fitted_gains(effect: PooledEffect, candidates: Sequence[Candidate]) -> dict[Candidate, float]:
    """Nats explained in sample, with the effect's noise models, by candidates that all recordings with the effect hold.

    One coefficient vector for all recordings, or one for each where the effect's coefficients differ.
    """
    left, own = [effect.here[i].as_left for i in effect.shown], effect.transfer is Transfer.NOT_TRANSFERRED
    return {
        candidate: sum(one.gain(one.c) for one in (estimates if own else [pool_estimates(estimates)]))
        for candidate, estimates in estimates_of(candidates, left).items()
        if len(estimates) == len(left)
    }
