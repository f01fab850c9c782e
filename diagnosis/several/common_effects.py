"""Effects common to several recordings, with their values in each and the test of agreement."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.monotone_courses import with_rival_channels
from diagnosis.decision.sentence import main_parameter
from diagnosis.evidence.held_out import Evidence
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import EvidenceKind, NamedEffect, Transfer
from diagnosis.several.coefficients import (
    Agreement,
    CoefficientEstimate,
    agreement,
    cross_predicted_gain,
    inverse,
    root,
    size_ratios,
)
from diagnosis.several.pooled_effect import PooledEffect, Presence
from diagnosis.several.transfer import transfer_of
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.amplitude import rms

STEP = 1e-3
"""Step of a coefficient over its standard deviation, and of a listed value over itself, for a finite difference."""
Named = TypeVar("Named", AcceptedEffect, NamedEffect)


@dataclass(frozen=True)
class CommonEffect:
    """One effect in n recordings: pooled, in each recording by itself (None: unknown), and the test of agreement.

    agreement: of the coefficients; None for effects without. ratios: size in each recording over the size in all other
    recordings, with standard deviation.
    """

    named: NamedEffect
    each: tuple[NamedEffect | None, ...]
    presence: tuple[Presence, ...]
    agreement: Agreement | None = None
    ratios: tuple[tuple[float, float] | None, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.named.name

    @property
    def transfer(self) -> Transfer:
        """Whether the recordings agree."""
        return self.named.transfer


def common_effect(effect: PooledEffect, problems: Sequence[LinearProblem]) -> CommonEffect:
    """The parameters of an effect of the pool: pooled, and in each recording by itself.

    Rivals are the channels that may drive the effect as well in all recordings that show it.
    """
    fits = {i: (effect.estimates[i], one.held_out_gain / one.inflation) for i, one in effect.here.items()}
    presence = [effect.presence.get(i, Presence.NOT_RECORDED) for i in range(len(problems))]
    named = NamedEffect(
        effect.candidate.to_effect(effect.agreement.c),
        effect.alternatives,
        EvidenceKind.HELD_OUT,
        effect.nats,
        effect.strength,
        transfer=effect.transfer or Transfer.SINGLE_RUN,
    )
    common = _with_parameters(named, effect.candidate, effect.agreement, fits, presence, problems)
    rivals = in_all([with_rival_channels(problems[i], common.named).rivals for i in effect.present])
    return replace(common, named=replace(common.named, rivals=rivals))


def common_iron_changes(
    changes_of_each: Sequence[Sequence[AcceptedEffect]], problems: Sequence[LinearProblem]
) -> list[CommonEffect]:
    """Changes of the iron found in more than one recording, each predicted by the others with enough gain.

    The mean of a wander differs from run to run.
    """
    policy, n, common = problems[0].policy, len(problems), []
    for changes in _by_name(changes_of_each).values():
        found = {i: change.evidence for i, change in changes.items()}
        fits = {i: (_estimate(evidence), evidence.nats) for i, evidence in found.items()}
        estimates, nats = zip(*fits.values(), strict=True)
        if cross_predicted_gain(estimates) > policy.accepted_pooled(len(EFFECTS)):
            agree, candidate = agreement(estimates, policy.same_coefficient), found[min(found)].candidate
            named = NamedEffect(
                candidate.to_effect(agree.c),
                in_all([change.alternatives for change in changes.values()]),
                EvidenceKind.IRON,
                sum(nats),
                rms([evidence.strength for evidence in found.values()]),
                transfer=transfer_of(agree.p > policy.not_transferred_alarm, len(fits), n),
            )
            common.append(_with_parameters(named, candidate, agree, fits, _presences(fits, n), problems))
    return common


def _estimate(evidence: Evidence) -> CoefficientEstimate:
    N = inverse(evidence.covariance * max(evidence.V, 1.0))
    return CoefficientEstimate(N, N @ evidence.coefficients)


def _with_parameters(
    named: NamedEffect,
    candidate: Candidate,
    agree: Agreement,
    fits: Mapping[int, tuple[CoefficientEstimate, float]],
    presence: Iterable[Presence],
    problems: Sequence[LinearProblem],
) -> CommonEffect:
    """The effect with the parameters of the common coefficients, and of each recording's own; fits : with nats."""

    def fitted(c: Array, covariance: Array, i: int, **own: Any) -> NamedEffect:
        effect, spread = parameters_of(candidate, c, covariance, problems[i])
        return replace(named, effect=effect, spread=spread, **own)

    known = {i: fitted(own.c, own.covariance, i, alternatives=(), nats=nats) for i, (own, nats) in fits.items()}
    ratios, every = size_ratios({i: own for i, (own, _) in fits.items()}), range(len(problems))
    each, of_each = tuple(map(known.get, every)), tuple(map(ratios.get, every))
    return CommonEffect(fitted(agree.c, agree.covariance, min(fits)), each, tuple(presence), agree, of_each)


def in_all(lists: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Names in every list, in the order of the first; none without lists."""
    return tuple(name for name in (lists[0] if lists else ()) if all(name in other for other in lists))


def common_value_effects(effects_of_each: Sequence[Sequence[NamedEffect]], policy: Policy) -> list[CommonEffect]:
    """Noise and direct evidence in more than one recording, common where the sizes are alike.

    Slow noise has one size in all recordings; noise of varying size comes from outside the sensor.
    """
    n, common = len(effects_of_each), []
    for effects in _by_name(effects_of_each).values():
        known = sorted(effects.values(), key=lambda effect: main_size(effect.effect))
        alike = main_size(known[-1].effect) <= policy.somewhat_larger * main_size(known[0].effect)
        named = replace(known[len(known) // 2], transfer=transfer_of(alike, len(known), n))
        slow = named.kind is EvidenceKind.SPECTRUM and named.effect.traits.spectrum is not None
        if len(known) > 1 and (named.transfer is Transfer.TRANSFERRED or not slow):
            common.append(CommonEffect(named, tuple(map(effects.get, range(n))), _presences(effects, n)))
    return common


def _by_name(of_each: Sequence[Sequence[Named]]) -> dict[str, dict[int, Named]]:
    """The first effect of each name in each recording, by name and index of the recording."""
    found: dict[str, dict[int, Named]] = {}
    for i, effects in enumerate(of_each):
        for effect in effects:
            found.setdefault(effect.name, {}).setdefault(i, effect)
    return found


def _presences(known: Mapping[int, object], n: int) -> tuple[Presence, ...]:
    return tuple(Presence.PRESENT if i in known else Presence.UNDECIDED for i in range(n))


def main_size(effect: Effect) -> float:
    """Size of the main parameter of an effect, in its unit."""
    return float(np.linalg.norm(np.asarray(getattr(effect, main_parameter(effect).name), dtype=float)))


def parameters_of(
    candidate: Candidate, c: Array, covariance: Array, problem: LinearProblem
) -> tuple[Effect, dict[str, Array]]:
    """Return the effect with coefficients (k,) of covariance (k, k), and the standard deviations of its parameters.

    ``C_p = J R^T R J^T`` with the slopes J of the parameters, as finite differences along the rows of a root R of C.
    """
    listed = not candidate.effect.linear and not candidate.effect.tangents
    effect_at = _listed_effect(candidate, problem) if listed else candidate.to_effect
    effect, moved, spread = effect_at(c), [effect_at(c + STEP * row) for row in root(covariance)], {}
    for p in effect.parameters():
        if (listed or p.name not in dict(candidate.nonlinear)) and not p.worded:
            changes = np.array([getattr(one, p.name) for one in moved]) - np.asarray(getattr(effect, p.name))
            if changes.any():
                spread[p.name] = np.linalg.norm(changes, axis=0) / STEP
    return effect, spread


def _listed_effect(candidate: Candidate, problem: LinearProblem) -> Callable[[Array], Effect]:
    """The effect by coefficient c (1,) of a column at a listed value v, ``v c^(1/p)``, within the value's bounds.

    The size of the column varies as v to the power ``p = d ln|E| / d ln v``.
    """
    ((name, value),) = candidate.nonlinear
    sizes = [float(np.linalg.norm(candidate.at({name: value * by}).columns(problem))) for by in (1.0, 1.0 + STEP)]
    p = float(np.log(sizes[1] / sizes[0]) / np.log1p(STEP))
    low, high = next((one.low, one.high) for one in candidate.effect.parameters() if one.name == name)

    def effect_at(c: Array) -> Effect:
        values: dict[str, Any] = {name: float(np.clip(value * max(c[0], STEP) ** (1 / p), low, high))}
        return candidate.effect(**values)

    return effect_at
