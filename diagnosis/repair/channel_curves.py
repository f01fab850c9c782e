"""Curves of channels as names: coefficients fitted together, with their covariance, and the gap that they leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.decision.curves import Curve, curves
from diagnosis.decision.verdict_rules import VerdictInput, unnamed_channels
from diagnosis.evidence.baseline import Baseline
from diagnosis.problem.blocks import fit, inflation
from diagnosis.repair.named_effects import ModelledGap
from diagnosis.result import GapSize, How, Named
from scenarios.arrays import Array


@dataclass(frozen=True)
class Followed:
    """Curves of channels as names, and what they leave together."""

    named: tuple[Named, ...]
    left: ModelledGap

    @property
    def explained(self) -> float:
        """Share of the gap on held-out data."""
        return self.left.gap.explained or 0.0


def followed(start: Baseline, ground: Baseline | None = None) -> Followed | None:
    """The channels that a gap follows, where curves of such stand; start : the ground without any effect.

    ground : that with effects which explain too little to be names, but may hide such a channel.
    """
    found = curves(start, ground)
    if not found:
        return None
    columns = [one.candidate.columns(start.problem) for one in found]
    end = start.beside(np.concatenate(columns, axis=2))
    all_of_it = Followed(tuple(_named(found, end, [one.shape[2] for one in columns])), _left(start, end))
    return all_of_it if all_of_it.explained >= start.problem.policy.least_share else None


def followed_instead(start: Baseline, case: VerdictInput) -> Followed | None:
    """Curves that explain much more than names do, where the gap goes first with a channel that no name follows.

    A name whose cause is that channel stays: a curve gains what its form lacks.
    """
    if not case.where or case.where[0].channel not in unnamed_channels(case):
        return None
    found, explained = followed(start), case.gap.explained or 0.0
    if found is None or 1 - found.explained > start.problem.policy.curve_left * (1 - explained):
        return None
    return found


def _left(start: Baseline, end: Baseline) -> ModelledGap:
    """What is left before, by iron that was fitted to all, and after, by what the first split trains on.

    Iron of a motion that hardly shows it leaves far more of what it was not fitted to: no gap, and nothing explains it.
    """
    problem = start.problem
    before, after = start.residual(), end.residual(~start.splits[0])
    test = end.held_samples() & (problem.usable > 0)
    return ModelledGap(before, after, GapSize.of(before[test], after[test], problem.sigma_nT, problem.policy))


def _named(found: Sequence[Curve], end: Baseline, widths: Sequence[int]) -> list[Named]:
    """Each curve with its coefficients of the joint fit; the covariance is widened by what is still coloured."""
    whole = fit(end.sums, end.everything)
    V = inflation(end.sums, whole, end.problem.policy)
    places = [slice(at - k, at) for at, k in zip(np.cumsum(widths), widths, strict=True)]
    return [
        _one(curve, whole.c[i], V * whole.covariance[i, i], end.problem.policy.coloured_nats)
        for curve, i in zip(found, places, strict=True)
    ]


def _one(curve: Curve, c: Array, covariance: Array, needed: float) -> Named:
    effect, evidence = curve.candidate.made(c), curve.evidence
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    spread: dict[str, Array] = {}
    for (name, unit), one in zip(effect.linear_units(), std, strict=True):
        spread[name] = np.hypot(spread.get(name, 0.0), unit * one)
    return Named(
        effect,
        (),
        How.CURVE,
        evidence.nats,
        evidence.strength,
        spread,
        needed=needed,
        covariance=covariance,
        rivals=curve.rivals,
    )
