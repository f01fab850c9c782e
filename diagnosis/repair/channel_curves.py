"""Curves of recorded channels, the last resort where no effect of the library is accepted, as named effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.coloured_choice import beyond_chance
from diagnosis.decision.selection import residual_tests
from diagnosis.decision.verdict_rules import unnamed_channels
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
from diagnosis.result import EvidenceKind, Explanation, GapSize, NamedEffect
from recordings.channels import HEIGHT
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers


@dataclass(frozen=True)
class AcceptedCurve:
    """An accepted curve with its channel, its evidence, and the channels that do equally well."""

    channel: str
    evidence: Evidence
    rivals: tuple[str, ...]


def follow_channels(start: Baseline, found: Explanation) -> Explanation | None:
    """Explain a gap by curves of channels in place of effects, where curves are accepted.

    start : the baseline without effects.
    """
    problem, curves = start.problem, select_curves(start)
    if not curves:
        return None
    end = start.with_all(curve.evidence.candidate.columns(problem) for curve in curves)
    # before, with iron fitted to all data: iron hardly shown by the motion leaves far more on held-out data, and such
    # a difference is no gap
    before, after = start.residual(), end.residual(~start.splits[0])
    gap = GapSize.of(problem, before, after, end.held_out_samples())
    if (gap.explained or 0.0) < problem.policy.fair_share:
        return None
    named = (*found.of_kind(EvidenceKind.DIRECT), *_named_curves(curves, end))
    before_nT, after_nT = before * problem.sigma_nT, after * problem.sigma_nT
    return replace(found, named=named, before_nT=before_nT, after_nT=after_nT, gap=gap)


def better_channels(start: Baseline, found: Explanation) -> Explanation | None:
    """Find curves that explain much more than the named effects, none of which follows the first channel of the gap.

    An effect driven by the first channel stays: a curve gains by the effect's form error.
    """
    if not found.where or found.where[0].channel not in unnamed_channels(found):
        return None
    followed = follow_channels(start, found)
    left = start.problem.policy.half * (1 - (found.gap.explained or 0.0))
    return followed if followed and 1 - (followed.gap.explained or 0.0) <= left else None


def _named_curves(curves: Sequence[AcceptedCurve], end: Baseline) -> list[NamedEffect]:
    """Each curve with its coefficients of the joint fit, their covariance widened by the colour of the residual."""
    whole, policy = fit(end.sums, end.all_folds), end.problem.policy
    covariances, named, at = inflation(end.sums, whole, policy) * whole.covariance, list[NamedEffect](), 0
    for curve, columns in zip(curves, end.accepted_columns, strict=True):
        own, evidence = slice(at, at := at + columns.shape[2]), curve.evidence
        effect, covariance = evidence.candidate.to_effect(whole.c[own]), covariances[own, own]
        spread: dict[str, Array] = {}
        for (name, unit), variance in zip(effect.linear_units(), np.diag(covariance), strict=True):
            spread[name] = np.hypot(spread.get(name, 0.0), unit * max(variance, 0.0) ** 0.5)
        found = NamedEffect(effect, (), EvidenceKind.CURVE, evidence.nats, evidence.strength, spread)
        named.append(replace(found, needed=policy.coloured_nats, covariance=covariance, rivals=curve.rivals))
    return named


def select_curves(start: Baseline) -> tuple[AcceptedCurve, ...]:
    """Select curves of channels in turn; each must beat slow noise and any course of time of its order.

    Motion is a rival: where a curve of the field, a rate, an angle or a position explains more, no channel drives the
    gap. start : the baseline without effects, a share of whose gap a curve must explain.
    """
    problem, baseline, curves = start.problem, start, list[AcceptedCurve]()
    known = find_drivers(problem)
    while known and len(curves) < problem.policy.most_curves and not (curves and residual_tests(baseline, ()).clean):
        chosen = _next_curve(baseline, start, known, first=not curves)
        if chosen is None:
            break
        curves.append(chosen)
        known = [driver for driver in known if driver.name != chosen.channel]
        baseline = baseline.with_columns(chosen.evidence.candidate.columns(problem))
    return tuple(curves)


def _next_curve(baseline: Baseline, start: Baseline, known: Sequence[Driver], *, first: bool) -> AcceptedCurve | None:
    """The best accepted curve; curves after the first need to add less."""
    policy = baseline.problem.policy
    least_share = policy.fair_share if first else policy.trace
    screening = DriverScreening.of(baseline)
    beside, fits = screening.coloured_baseline, _fitted_curves(baseline, screening, known)
    for best in sorted(fits, key=lambda fit: -fit.gain):
        inflation, refusal = beyond_chance(best, beside, baseline.problem, policy.coloured_nats)
        chosen = None if refusal else judge_settings(baseline, [_simplest(best, beside, baseline, inflation)])
        if chosen is None or added_share(start, baseline, chosen.squares) < least_share:
            continue
        rivals = [fit for fit in fits if fit is not best]
        alike = find_look_alikes(best, rivals, beside, policy.apart * inflation, policy.same_coloured)
        channel, *others = (channel_of(fit.evidence.candidate) for fit in (best, *alike))
        return AcceptedCurve(channel, replace(chosen, gain=best.gain, V=inflation), tuple(others))
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


def _simplest(best: CandidateFit, beside: ColouredBaseline, baseline: Baseline, inflation: float) -> Candidate:
    """The curve of the lowest order that the data do not distinguish from the highest.

    Its lag is interpolated between listed lags where the misfit is then smaller beyond chance.
    """
    k, noise_model, policy = best.columns.shape[2] // HIGHEST, best.hypothesis.noise_model, baseline.problem.policy
    several = [beside.columns_with(best.columns[:, :, : k * order]) for order in range(1, HIGHEST + 1)]
    held = [
        Hypothesis.with_noise_model(beside.rows, columns, noise_model).held_out_log_likelihood for columns in several
    ]
    order = 1 + int(np.argmax(np.array(held) >= max(held) - policy.apart * inflation))
    curve = best.evidence.candidate.at({"order": order})
    finer = refine_between_neighbours(curve, lambda candidate: misfit(baseline, candidate))
    better = finer and misfit(baseline, curve) - misfit(baseline, finer) > 2 * policy.apart
    return finer if finer and better else curve


def channel_of(candidate: Candidate) -> str:
    """Name of the channel of a curve."""
    return str(dict(candidate.nonlinear)["channel"])
