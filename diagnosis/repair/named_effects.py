"""Names for a gap, effects with refined parameters or curves of recorded channels, and the gap they explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.choice import AcceptedEffect, Selection, residual_tests
from diagnosis.decision.monotone_courses import with_rival_channels
from diagnosis.decision.verdict_rules import unnamed_channels
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, find_look_alikes
from diagnosis.evidence.direct import DirectFinding
from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.held_out import judge_settings, misfit
from diagnosis.evidence.hypothesis import Hypothesis
from diagnosis.evidence.localise import TIME, channels
from diagnosis.evidence.residual_tests import missing_white_noise
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, CHANNEL_LAGS, LAGS, Driver, Lag, find_drivers, in_axes
from diagnosis.library.parameter_search import refine_between_neighbours
from diagnosis.problem.blocks import fit, inflation
from diagnosis.repair.refinement import chain_residual, refine
from diagnosis.result import EvidenceKind, Explanation, NamedEffect
from recordings.channels import HEIGHT
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.channels import HIGHEST, powers


def explain(selection: Selection, direct: Sequence[DirectFinding]) -> Explanation:
    """Name all effects: accepted effects and changes of the iron, refined, then direct evidence, then noise.

    For the gap, parameters and iron are fitted to the training data of the first split. Without effects and with a
    clean residual there is no gap: excess over the noise is chance.
    """
    problem, held_out, noise = selection.end.problem, selection.end.held_out_samples(), selection.coloured_noise
    refined, spread = _refined(selection)
    effects = _named_effects(selection, refined, spread)
    named = [*effects, *named_values(selection, direct, effects)]
    if problem.mode == "vector":
        train = ~held_out & (problem.usable > 0)
        trained, _ = refine(problem, refined, train, noise=noise)
        before, after = (chain_residual(problem, new, train) for new in (problem.left_out, trained))
    else:
        before = selection.start.residual()
        after = selection.end.residual() if selection.accepted else before
    found = Explanation.by(problem, named, (before, after), held_out, selection.after, clean=selection.clean)
    some = selection.accepted or selection.iron or not selection.after.clean
    return found if some else replace(found, gap=replace(found.gap, explained=None))


def _refined(selection: Selection) -> tuple[Sequence[Effect], Sequence[dict[str, Array]]]:
    """Accepted effects, changes of the iron and conventions, refined, with their standard deviations."""
    end, problem, noise = selection.end, selection.end.problem, selection.coloured_noise
    found = (one.evidence for one in (*selection.accepted, *selection.iron, *selection.conventional))
    effects = [evidence.candidate.to_effect(evidence.coefficients) for evidence in found]
    V = inflation(end.sums, fit(end.sums, end.all_folds), problem.policy) if noise is None else 1.0
    every = np.ones(len(problem.recording), bool)
    return refine(problem, effects, every, V, refit_iron=not problem.iron_known, noise=noise)


def _named_effects(
    selection: Selection, effects: Sequence[Effect], spread: Sequence[dict[str, Array]]
) -> list[NamedEffect]:
    """Accepted effects and changes of the iron, as refined; forms, and iron restating a reference, are no causes."""
    problem = selection.end.problem
    accepted = [(effect, EvidenceKind.HELD_OUT) for effect in selection.accepted]
    accepted += [(effect, EvidenceKind.IRON) for effect in selection.iron]
    causes, conventional = _by_cause(accepted, effects, spread), effects[len(accepted) :]
    for key, cause in causes.items() if conventional else ():
        if cause.effect.convention_columns(problem.state, problem.clean_nT).shape[2]:
            causes[key] = replace(cause, also=(*cause.also, *conventional))
            break
    return [with_rival_channels(problem, cause) for cause in causes.values()]


def _by_cause(
    accepted: Sequence[tuple[AcceptedEffect, EvidenceKind]],
    effects: Sequence[Effect],
    spread: Sequence[dict[str, Array]],
) -> dict[tuple[str, EvidenceKind], NamedEffect]:
    """Accepted effects with their fits by name and kind of the cause."""
    causes: dict[tuple[str, EvidenceKind], NamedEffect] = {}
    for (one, kind), effect, std in zip(accepted, effects, spread, strict=False):
        key, (nats, strength) = (one.form_of or one.name, kind), (one.evidence.nats, one.evidence.strength)
        if (cause := causes.get(key)) is None:
            causes[key] = NamedEffect(effect, one.alternatives, kind, nats, strength, std, needed=one.needed)
        else:
            others = [name for name in (*cause.alternatives, effect.name, *one.alternatives) if name != cause.name]
            causes[key] = replace(cause, alternatives=tuple(dict.fromkeys(others)), also=(*cause.also, effect))
    return causes


def named_values(
    selection: Selection, direct: Sequence[DirectFinding], effects: Sequence[NamedEffect]
) -> list[NamedEffect]:
    """Direct evidence, then slow noise, or white noise in excess of the model's and of the named effects'."""
    problem, noise = selection.end.problem, selection.noise
    seen = [NamedEffect(finding.effect, (), EvidenceKind.DIRECT, None, 0.0) for finding in direct]
    if noise is not None:
        ranking = sorted((result.evidence for result in selection.results), key=lambda evidence: -evidence.gain)
        slow = [evidence.name for evidence in ranking if evidence.nats > problem.policy.apart]
        listed = () if noise.identified else slow[: problem.policy.listed_noises]
        alternatives = (*noise.alternatives, *listed)
        return [*seen, NamedEffect(noise.effect, alternatives, EvidenceKind.SPECTRUM, noise.gain, 0.0)]
    known = [cause.effect for cause in (*effects, *seen)]
    noisier = missing_white_noise(problem, selection.end.residual(), known)
    if noisier is None or noisier.name in selection.without:
        return seen
    return [*seen, NamedEffect(noisier, (), EvidenceKind.SPECTRUM, None, 0.0)]


def follow_channels(start: Baseline, found: Explanation) -> Explanation | None:
    """Explain a gap by curves of channels in place of effects, where accepted; start : the baseline without effects."""
    problem, (curves, end) = start.problem, select_curves(start)
    if not curves:
        return None
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


def _named_curves(curves: Sequence[AcceptedEffect], end: Baseline) -> list[NamedEffect]:
    """Each curve with its coefficients of the joint fit, their covariance widened by the colour of the residual."""
    whole = fit(end.sums, end.all_folds)
    covariances, named, at = inflation(end.sums, whole, end.problem.policy) * whole.covariance, list[NamedEffect](), 0
    for curve in curves:
        own, evidence = slice(at, at := at + curve.evidence.width), curve.evidence
        effect, covariance = evidence.candidate.to_effect(whole.c[own]), covariances[own, own]
        spread: dict[str, Array] = {}
        for (name, unit), variance in zip(effect.linear_units(), np.diag(covariance), strict=True):
            spread[name] = np.hypot(spread.get(name, 0.0), unit * max(variance, 0.0) ** 0.5)
        found = NamedEffect(effect, (), EvidenceKind.CURVE, evidence.nats, evidence.strength, spread)
        named.append(replace(found, needed=curve.needed, covariance=covariance, rivals=curve.alternatives))
    return named


def select_curves(start: Baseline) -> tuple[list[AcceptedEffect], Baseline]:
    """Select curves of channels in turn, each with the channels that do equally well; the baseline with all curves.

    Each must beat slow noise and any course of time of its order. Motion is a rival: where a curve of the field, a
    rate, an angle or a position explains more, no channel drives the gap. start : the baseline without effects, a share
    of whose gap a curve must explain.
    """
    policy, baseline, curves, known = start.problem.policy, start, list[AcceptedEffect](), find_drivers(start.problem)
    while known and len(curves) < policy.most_curves and not (curves and residual_tests(baseline, ()).clean):
        chosen = CurveRound.of(baseline).next_curve(start, known)
        if chosen is None:
            break
        curves.append(chosen)
        known = [driver for driver in known if driver.name != channel_of(chosen)]
        baseline = baseline.with_columns(chosen.columns(start.problem))
    return curves, baseline


@dataclass(frozen=True, eq=False)
class CurveRound:
    """The choice of the next curve: a baseline, and its noise model next to any course of time of the curves' order.

    unit (rows, q, 3) : row means of each sensor axis.
    """

    baseline: Baseline
    beside: ColouredBaseline
    unit: Array

    @classmethod
    def of(cls, baseline: Baseline) -> CurveRound:
        """The round next to the accepted curves of a baseline."""
        problem, time_s = baseline.problem, baseline.problem.state.time_s
        unit = problem.sensor_axes(np.ones(len(time_s)))
        clock = np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1)
        beside = ColouredBaseline.of(problem, (*baseline.accepted_columns, in_axes(unit, powers(clock, HIGHEST))))
        return cls(baseline, beside, beside.rows.bin(unit))

    def next_curve(self, start: Baseline, known: Sequence[Driver]) -> AcceptedEffect | None:
        """The best accepted curve of the known drivers; curves after the first need to add less."""
        policy, fits = start.problem.policy, self.fits(known)
        least_share = policy.fair_share if self.baseline is start else policy.trace
        for best in sorted(fits, key=lambda fit: -fit.gain):
            inflation, refusal = self.beside.beyond_chance(best, policy.coloured_nats)
            chosen = None if refusal else judge_settings(self.baseline, [self._simplest(best, inflation)])
            if chosen is not None and added_share(start, self.baseline, chosen.squares) >= least_share:
                others = [fit for fit in fits if fit is not best]
                alike = find_look_alikes(best, others, self.beside, policy.apart * inflation, policy.same_coloured)
                rivals = tuple(channel_of(fit) for fit in alike)
                return AcceptedEffect(replace(chosen, gain=best.gain, V=inflation), rivals, policy.coloured_nats)
        return None

    def fits(self, known: Sequence[Driver]) -> list[CandidateFit]:
        """The best screened channels, each of the highest order and with a noise model of its own.

        Empty where a quantity of the motion outside the recorded channels gains more.
        """
        problem, policy = self.baseline.problem, self.baseline.problem.policy
        recorded = {TIME, HEIGHT, *problem.state.channels}
        motion = [Driver.of(name, x, policy) for name, x in channels(problem) if name not in recorded]
        motion_nats = max((self.best_lag(driver, (AT_ONCE,))[0] for driver in motion if driver), default=0.0)
        ranked = sorted(((self.best_lag(driver, CHANNEL_LAGS)[0], driver) for driver in known), key=lambda one: -one[0])
        if ranked[0][0] <= max(motion_nats, policy.coloured_nats):
            return []
        tried, best = len(known) * len(LAGS) * HIGHEST, [driver for _, driver in ranked[: policy.tried_coloured]]
        curves = (driver.candidate(self.best_lag(driver, LAGS)[1], tried) for driver in best)
        judged = (judge_settings(self.baseline, [curve]) for curve in curves)
        found = [evidence for evidence in judged if evidence is not None]
        return [self.beside.fit_candidate(one, self.beside.columns_of(one.candidate)) for one in found]

    def best_lag(self, driver: Driver, ways: Sequence[Lag]) -> tuple[float, Lag]:
        """The nats that the curve of a driver gains at its best lag, and the lag.

        A lag longer than the run makes the curve a sum over time: no run can show a driver behind it.
        """
        rows, state = self.beside.rows, self.baseline.problem.state
        ways = [way for way in ways if way.lag_s < np.ptp(state.time_s)]
        root = np.sqrt(np.maximum(rows.count, 1.0))[:, None]
        terms = [rows.bin(driver.terms(way, state.interval_s) * rows.usable[:, None]) / root for way in ways]
        nats = self.beside.screening_gains([in_axes(self.unit, curve) for curve in terms])
        best = int(np.argmax(nats))
        return float(nats[best]), ways[best]

    def _simplest(self, best: CandidateFit, inflation: float) -> Candidate:
        """The curve of the lowest order as good as the highest, its lag between listed ones if better beyond chance."""
        beside, noise_model, apart = self.beside, best.hypothesis.noise_model, self.baseline.problem.policy.apart
        columns = (best.columns[:, :, : 3 * order] for order in range(1, HIGHEST + 1))
        fits = (Hypothesis.with_noise_model(beside.rows, beside.columns_with(some), noise_model) for some in columns)
        held = np.array([fit.held_out_log_likelihood for fit in fits])
        curve = best.evidence.candidate.at({"order": 1 + int(np.argmax(held >= held.max() - apart * inflation))})
        finer = refine_between_neighbours(curve, lambda candidate: misfit(self.baseline, candidate))
        better = finer and misfit(self.baseline, curve) - misfit(self.baseline, finer) > 2 * apart
        return finer if finer and better else curve


def channel_of(curve: AcceptedEffect | CandidateFit) -> str:
    """Name of the channel of a curve."""
    return str(dict(curve.evidence.candidate.nonlinear)["channel"])
