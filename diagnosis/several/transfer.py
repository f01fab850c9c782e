"""Transfer of an effect between recordings: equal in all, of differing size, in some, or in one; confirmation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from diagnosis.decision.advice import advice_for
from diagnosis.decision.sentence import sentence_for
from diagnosis.evidence.reference_checks import correct_reference
from diagnosis.library.candidates import Candidate
from diagnosis.problem.formulation import pose_model
from diagnosis.result import FITTED, Diagnosis, NamedEffect, Transfer
from diagnosis.several.pooled_effect import PooledEffect, Presence
from diagnosis.workflow import measured_rows
from recordings import Recording
from scenarios.arrays import Array
from sim.scenario import Model


def assess_transfer(pooled: PooledEffect, needed: float, named: Sequence[int] = ()) -> PooledEffect:
    """Assess the transfer of an effect; needed : nats of predicted coefficients for acceptance.

    An effect whose size differs between recordings is accepted where two of them show the effect by themselves, and the
    predicted size still explains more than nothing, or both name the effect, as a tone of random phase. named : the
    recordings whose own diagnosis names the effect.
    """
    every = pooled.predicted(pooled.here)
    if every.agrees and every.is_borne_out(needed):
        return replace(every, transfer=Transfer.TRANSFERRED)
    return every if len(pooled.present) < 2 else _assess_shown(pooled.predicted(pooled.present), needed, named)


def _assess_shown(shown: PooledEffect, needed: float, named: Sequence[int]) -> PooledEffect:
    """Assess the transfer among the recordings that show an effect, two or more."""
    supported = shown.is_borne_out(needed)
    if supported and shown.agrees and Presence.ABSENT in shown.presence.values():
        return replace(shown, transfer=Transfer.SOME)
    alone = [own for i in shown.present if (supported or i in named) and (own := shown.own_nats(i)) > needed]
    if len(alone) < 2:
        return shown
    return replace(shown, transfer=Transfer.NOT_TRANSFERRED, gains=shown.gains if supported else alone)


def compare_sensors(pooled: PooledEffect) -> PooledEffect:
    """Assess the transfer between the sensors of an array of an effect named by one; None if a single sensor shows it.

    Coefficients are those of the sensors with the effect, and no more certain than one sensor's: all sensors share the
    slow errors of the run.
    """
    n, shown = len(pooled.shown), pooled.predicted(pooled.shown)
    agree = replace(shown.agreement, covariance=n * shown.agreement.covariance)
    transfer = transfer_of(shown.agrees, n, len(pooled.here)) if n > 1 else None
    return replace(shown, transfer=transfer, agreement=agree)


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
    transferred where the coefficients of the first explain the second, in nats over the inflation of their error, and
    agree with the estimate of the second. Events of a single run and effects in a window cannot be confirmed.
    """
    whole = pose_model(second, model, field_enu_nT, strength_nT, policy=found.problem.policy)
    throughout = [one for one in found.named if one.kind in FITTED and one.effect.active_s is None]
    effects = [effect for one in throughout for effect in one.effects if not effect.traits.absorbed]
    problems = (found.problem, correct_reference(measured_rows(whole)[0]))

    def confirm(one: NamedEffect) -> NamedEffect:
        if not one.transferable or found.problem.mode != problems[1].mode:
            return one
        others = [Candidate.of(effect) for effect in effects if effect is not one.effect]
        holds = predicts(PooledEffect.beside(Candidate.of(one.effect), others, problems))
        return replace(one, transfer=Transfer.TRANSFERRED) if holds else one

    known = replace(found, named=tuple(confirm(one) for one in found.named), has_second=True)
    return replace(known, sentence=sentence_for(known), advice=advice_for(known))


def predicts(pooled: PooledEffect) -> bool:
    """Whether coefficients of a first recording explain a second, whose own coefficients agree."""
    if len(pooled.here) < 2:
        return False
    both = pooled.predicted(pooled.here)
    return both.gains[1] > pooled.policy.apart and both.agrees
