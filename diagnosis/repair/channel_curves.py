"""Curves of channels as named effects: joint fit of the coefficients with covariance, and the explained gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.decision.curves import AcceptedCurve, select_curves
from diagnosis.decision.verdict_rules import VerdictInput, unnamed_channels
from diagnosis.evidence.baseline import Baseline
from diagnosis.problem.blocks import fit, inflation
from diagnosis.repair.named_effects import ModelledGap
from diagnosis.result import EvidenceKind, GapSize, NamedEffect
from scenarios.arrays import Array


@dataclass(frozen=True)
class FollowedChannels:
    """Curves of channels as named effects, with the gap before and after."""

    named: tuple[NamedEffect, ...]
    modelled: ModelledGap

    @property
    def explained(self) -> float:
        """Explained share of the gap on held-out data."""
        return self.modelled.gap.explained or 0.0


def follow_channels(start: Baseline, baseline: Baseline | None = None) -> FollowedChannels | None:
    """Find the channels followed by a gap, where curves of channels are accepted; start : the baseline without effects.

    baseline : the same with effects that explain too little to be named, but may hide a channel.
    """
    curves = select_curves(start, baseline)
    if not curves:
        return None
    columns = [curve.candidate.columns(start.problem) for curve in curves]
    end = start.with_columns(np.concatenate(columns, axis=2))
    named = _named_curves(curves, end, [of_curve.shape[2] for of_curve in columns])
    followed = FollowedChannels(tuple(named), _modelled_gap(start, end))
    return followed if followed.explained >= start.problem.policy.fair_share else None


def better_channels(start: Baseline, case: VerdictInput) -> FollowedChannels | None:
    """Find curves that explain much more than the named effects, none of which follows the first channel of the gap.

    An effect driven by the first channel stays: a curve gains by the effect's form error.
    """
    if not case.where or case.where[0].channel not in unnamed_channels(case):
        return None
    followed, explained = follow_channels(start), case.gap.explained or 0.0
    if followed is None or 1 - followed.explained > start.problem.policy.half * (1 - explained):
        return None
    return followed


def _modelled_gap(start: Baseline, end: Baseline) -> ModelledGap:
    """The gap before, with iron fitted to all data, and after, with iron and curves fitted to the training data.

    Iron hardly shown by the motion leaves far more on held-out data: such a difference is no gap.
    """
    problem = start.problem
    before, after = start.residual(), end.residual(~start.splits[0])
    test = end.held_out_samples() & (problem.usable > 0)
    return ModelledGap(before, after, GapSize.of(before[test], after[test], problem.sigma_nT, problem.policy))


def _named_curves(curves: Sequence[AcceptedCurve], end: Baseline, widths: Sequence[int]) -> list[NamedEffect]:
    """Each curve with its coefficients of the joint fit, their covariance widened by the colour of the residual."""
    whole = fit(end.sums, end.all_folds)
    V = inflation(end.sums, whole, end.problem.policy)
    slices = [slice(at - k, at) for at, k in zip(np.cumsum(widths), widths, strict=True)]
    return [
        _named_curve(
            curve, whole.c[of_curve], V * whole.covariance[of_curve, of_curve], end.problem.policy.coloured_nats
        )
        for curve, of_curve in zip(curves, slices, strict=True)
    ]


def _named_curve(curve: AcceptedCurve, c: Array, covariance: Array, needed: float) -> NamedEffect:
    effect, evidence = curve.candidate.to_effect(c), curve.evidence
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    spread: dict[str, Array] = {}
    for (name, unit), std_of_unit in zip(effect.linear_units(), std, strict=True):
        spread[name] = np.hypot(spread.get(name, 0.0), unit * std_of_unit)
    return NamedEffect(
        effect,
        (),
        EvidenceKind.CURVE,
        evidence.nats,
        evidence.strength,
        spread,
        needed=needed,
        covariance=covariance,
        rivals=curve.rivals,
    )
