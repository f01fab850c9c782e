"""Curves of recorded channels, the last resort where no effect of the library is accepted, as named effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.coloured_choice import beyond_chance
from diagnosis.decision.selection import residual_tests
from diagnosis.decision.verdict_rules import VerdictInput, unnamed_channels
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, find_look_alikes
from diagnosis.evidence.held_out import Evidence, judge_settings, misfit
from diagnosis.evidence.hypothesis import Hypothesis
from diagnosis.evidence.localise import TIME, channels
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, CHANNEL_LAGS, LAGS, Driver, Lag, find_drivers, in_axes
from diagnosis.library.parameter_search import refine_between_neighbours
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.named_effects import ModelledGap
from diagnosis.result import EvidenceKind, GapSize, NamedEffect
from recordings.channels import HEIGHT
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers


@dataclass(frozen=True)
class AcceptedCurve:
    """An accepted curve of a channel, and the channels that do equally well."""

    evidence: Evidence
    rivals: tuple[str, ...]

    @property
    def candidate(self) -> Candidate:
        """Channel, lag and order of the curve."""
        return self.evidence.candidate

    @property
    def channel(self) -> str:
        """Name of the channel."""
        return channel_of(self.candidate)


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
    if not (curves := select_curves(start, baseline)):
        return None
    end = start.with_all(curve.candidate.columns(start.problem) for curve in curves)
    followed = FollowedChannels(tuple(_named_curves(curves, end)), modelled_gap(start, end))
    return followed if followed.explained >= start.problem.policy.fair_share else None


def better_channels(start: Baseline, case: VerdictInput) -> FollowedChannels | None:
    """Find curves that explain much more than the named effects, none of which follows the first channel of the gap.

    An effect driven by the first channel stays: a curve gains by the effect's form error.
    """
    if not case.where or case.where[0].channel not in unnamed_channels(case):
        return None
    followed, explained = follow_channels(start), case.gap.explained or 0.0
    much_more = followed and 1 - followed.explained <= start.problem.policy.half * (1 - explained)
    return followed if much_more else None


def modelled_gap(start: Baseline, end: Baseline) -> ModelledGap:
    """The gap before, with iron fitted to all data, and after, with iron and curves fitted to the training data.

    Iron hardly shown by the motion leaves far more on held-out data: such a difference is no gap.
    """
    problem = start.problem
    before, after = start.residual(), end.residual(~start.splits[0])
    test = end.held_out_samples() & (problem.usable > 0)
    return ModelledGap(before, after, GapSize.of(before[test], after[test], problem.sigma_nT, problem.policy))


def _named_curves(curves: Sequence[AcceptedCurve], end: Baseline) -> list[NamedEffect]:
    """Each curve with its coefficients of the joint fit, their covariance widened by the colour of the residual."""
    whole, policy = fit(end.sums, end.all_folds), end.problem.policy
    covariances, named, at = inflation(end.sums, whole, policy) * whole.covariance, list[NamedEffect](), 0
    for curve, columns in zip(curves, end.accepted_columns, strict=True):
        own = slice(at, at := at + columns.shape[2])
        effect, covariance, spread = curve.candidate.to_effect(whole.c[own]), covariances[own, own], dict[str, Array]()
        std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        for (name, unit), std_of_unit in zip(effect.linear_units(), std, strict=True):
            spread[name] = np.hypot(spread.get(name, 0.0), unit * std_of_unit)
        found = NamedEffect(effect, (), EvidenceKind.CURVE, curve.evidence.nats, curve.evidence.strength, spread)
        named.append(replace(found, needed=policy.coloured_nats, covariance=covariance, rivals=curve.rivals))
    return named


def select_curves(start: Baseline, baseline: Baseline | None = None) -> tuple[AcceptedCurve, ...]:
    """Select curves of channels in turn; each must beat slow noise and any course of time of its order.

    Motion is a rival: where a curve of the field, a rate, an angle or a position explains more, no channel drives the
    gap. start : the baseline without effects, a share of whose gap a curve must explain. baseline : the baseline to
    which curves are added, `start` by default.
    """
    problem, baseline, curves = start.problem, baseline or start, list[AcceptedCurve]()
    known = find_drivers(problem)
    while known and len(curves) < problem.policy.most_curves and not (curves and residual_tests(baseline, ()).clean):
        chosen = _next_curve(baseline, start, known, first=not curves)
        if chosen is None:
            break
        curves.append(chosen)
        known = [driver for driver in known if driver.name != chosen.channel]
        baseline = baseline.with_columns(chosen.candidate.columns(problem))
    return tuple(curves)


def _next_curve(baseline: Baseline, start: Baseline, known: Sequence[Driver], *, first: bool) -> AcceptedCurve | None:
    """The best accepted curve; curves after the first need to add less."""
    policy, least_share = baseline.problem.policy, "fair_share" if first else "trace"
    screening = DriverScreening.of(baseline)
    beside, fits = screening.coloured_baseline, _fitted_curves(baseline, screening, known)
    for best in sorted(fits, key=lambda fit: -fit.gain):
        inflation, refusal = beyond_chance(best, beside, baseline.problem, policy.coloured_nats)
        if refusal:
            continue
        chosen = judge_settings(baseline, [_refined_lag(baseline, _lowest_order(best, beside, inflation))])
        if chosen is None or added_share(start, baseline, chosen.squares) < getattr(policy, least_share):
            continue
        rivals = [fit for fit in fits if fit is not best]
        alike = find_look_alikes(best, rivals, beside, policy.apart * inflation, policy.same_coloured)
        evidence = replace(chosen, gain=best.gain, V=inflation)
        return AcceptedCurve(evidence, tuple(channel_of(fit.evidence.candidate) for fit in alike))
    return None


def _fitted_curves(baseline: Baseline, screening: DriverScreening, known: Sequence[Driver]) -> list[CandidateFit]:
    """The best screened channels, each of the highest order and with a noise model of its own.

    Empty where a quantity of the motion outside the recorded channels gains more.
    """
    problem, policy, beside = baseline.problem, baseline.problem.policy, screening.coloured_baseline
    recorded = {TIME, HEIGHT, *problem.state.channels}
    motion = [Driver.of(name, x, policy) for name, x in channels(problem) if name not in recorded]
    motion_nats = max((screening.best(driver, (AT_ONCE,))[0] for driver in motion if driver is not None), default=0.0)
    ranked = sorted(((screening.best(driver, CHANNEL_LAGS)[0], driver) for driver in known), key=lambda one: -one[0])
    if ranked[0][0] <= max(motion_nats, policy.coloured_nats):
        return []
    judged = (
        judge_settings(baseline, [driver.candidate(screening.best(driver, LAGS)[1], len(known) * len(LAGS) * HIGHEST)])
        for _, driver in ranked[: policy.tried_coloured]
    )
    return [
        beside.fit_candidate(evidence, beside.rows.bin(evidence.candidate.columns(problem)))
        for evidence in judged
        if evidence is not None
    ]


@dataclass(frozen=True, eq=False)
class DriverScreening:
    """Screening of drivers with the baseline's noise model, by curves of row means; unit (rows, q, 3)."""

    problem: LinearProblem
    coloured_baseline: ColouredBaseline
    unit: Array

    @classmethod
    def of(cls, baseline: Baseline) -> DriverScreening:
        """Screen next to accepted effects and any course of time of the curves' order."""
        problem, time_s = baseline.problem, baseline.problem.state.time_s
        unit = problem.sensor_axes(np.ones(len(time_s)))
        clock = np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1)
        beside = ColouredBaseline.of(problem, (*baseline.accepted_columns, in_axes(unit, powers(clock, HIGHEST))))
        return cls(problem, beside, beside.rows.bin(unit))

    def best(self, driver: Driver, ways: Sequence[Lag]) -> tuple[float, Lag]:
        """The nats that the curve of a driver gains at its best lag, and the lag.

        A lag longer than the run makes the curve a sum over time: no run can show a driver behind it.
        """
        rows, state = self.coloured_baseline.rows, self.problem.state
        ways = [way for way in ways if way.lag_s < np.ptp(state.time_s)]
        root = np.sqrt(np.maximum(rows.count, 1.0))[:, None]
        terms = [rows.bin(driver.terms(way, state.interval_s) * rows.usable[:, None]) / root for way in ways]
        nats = self.coloured_baseline.screening_gains([in_axes(self.unit, curve) for curve in terms])
        best = int(np.argmax(nats))
        return float(nats[best]), ways[best]


def _lowest_order(best: CandidateFit, beside: ColouredBaseline, inflation: float) -> Candidate:
    """The curve of the lowest order that the data do not distinguish from the highest."""
    k, noise_model = best.columns.shape[2] // HIGHEST, best.hypothesis.noise_model
    several = [beside.columns_with(best.columns[:, :, : k * order]) for order in range(1, HIGHEST + 1)]
    held = [
        Hypothesis.with_noise_model(beside.rows, columns, noise_model).held_out_log_likelihood for columns in several
    ]
    near = max(held) - beside.rows.policy.apart * inflation
    order = next(i for i, nats in enumerate(held, start=1) if nats >= near)
    return best.evidence.candidate.at({"order": order})


def _refined_lag(baseline: Baseline, candidate: Candidate) -> Candidate:
    """The curve with its lag interpolated between listed lags, where the misfit is smaller beyond chance."""
    finer = refine_between_neighbours(candidate, lambda curve: misfit(baseline, curve))
    if finer is None or misfit(baseline, candidate) - misfit(baseline, finer) <= 2 * baseline.problem.policy.apart:
        return candidate
    return finer


def channel_of(candidate: Candidate) -> str:
    """Name of the channel of a curve."""
    return str(dict(candidate.nonlinear)["channel"])
