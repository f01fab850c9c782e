"""Curves of recorded channels, the last resort where no effect of the library is accepted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.selection import residual_tests
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, find_look_alikes
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.evidence.hypothesis import Hypothesis
from diagnosis.evidence.localise import TIME, channels
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, CHANNEL_LAGS, LAGS, Driver, Lag, find_drivers, in_axes
from diagnosis.library.parameter_search import refine_between_neighbours
from diagnosis.problem.blocks import fit, squares
from diagnosis.problem.linear import LinearProblem
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


@dataclass(frozen=True, eq=False)
class _ScreenedDriver:
    """A driver at its best lag, with its nats in the screening."""

    driver: Driver
    way: Lag
    nats: float


def select_curves(start: Baseline, baseline: Baseline | None = None) -> tuple[AcceptedCurve, ...]:
    """Select curves of channels in turn; each must beat slow noise and any course of time of its order.

    Motion is a rival: where a curve of the field, a rate, an angle or a position explains more, no channel drives the
    gap. start : the baseline without effects, a share of whose gap a curve must explain. baseline : the baseline to
    which curves are added, `start` by default.
    """
    problem, baseline, select_curves = start.problem, baseline or start, list[AcceptedCurve]()
    known = find_drivers(problem)
    while (
        known
        and len(select_curves) < problem.policy.most_curves
        and not (select_curves and residual_tests(baseline, ()).clean)
    ):
        chosen = _next_curve(baseline, start, known, first=not select_curves)
        if chosen is None:
            break
        select_curves.append(chosen)
        known = [driver for driver in known if driver.name != chosen.channel]
        baseline = baseline.with_columns(chosen.candidate.columns(problem))
    return tuple(select_curves)


def _next_curve(baseline: Baseline, start: Baseline, known: Sequence[Driver], *, first: bool) -> AcceptedCurve | None:
    """The best accepted curve; curves after the first need to add less."""
    policy = baseline.problem.policy
    screening = _DriverScreening.of(baseline)
    fits = _fitted_curves(baseline, screening, known)
    for best in sorted(fits, key=lambda fit: -fit.gain):
        by_chance = screening.coloured_baseline.surrogate_gains(best, baseline.problem)
        inflation = max(1.0, 2 * float(by_chance.mean()) / best.columns.shape[2])
        if best.gain / inflation <= policy.coloured_nats or best.gain <= by_chance.max():
            continue
        chosen = judge_settings(
            baseline, [_refined_lag(baseline, _lowest_order(best, screening.coloured_baseline, inflation))]
        )
        if chosen is None or _gap_share(start, baseline, chosen) < (policy.fair_share if first else policy.trace):
            continue
        rivals = [fit for fit in fits if fit is not best]
        alike = find_look_alikes(
            best, rivals, screening.coloured_baseline, policy.apart * inflation, policy.same_coloured
        )
        evidence = replace(chosen, gain=best.gain, V=inflation)
        return AcceptedCurve(evidence, tuple(channel_of(fit.evidence.candidate) for fit in alike))
    return None


def _gap_share(start: Baseline, baseline: Baseline, chosen: Evidence) -> float:
    return added_share(start, baseline, baseline.with_columns(chosen.candidate.columns(baseline.problem)).squares)


def _fitted_curves(baseline: Baseline, screening: _DriverScreening, known: Sequence[Driver]) -> list[CandidateFit]:
    """The best screened channels, each fitted with a noise model of its own; empty where a motion gains more."""
    policy = baseline.problem.policy
    best = sorted((screening.best(driver, CHANNEL_LAGS) for driver in known), key=lambda driver: -driver.nats)[
        : policy.tried_coloured
    ]
    motion_nats = max(
        (screening.best(driver, (AT_ONCE,)).nats for driver in _motion_drivers(baseline.problem)), default=0.0
    )
    if best[0].nats <= max(motion_nats, policy.coloured_nats):
        return []
    fits = [
        _fit_curve(baseline, screening.coloured_baseline, screening.best(driver.driver, LAGS), len(known))
        for driver in best
    ]
    return [driver for driver in fits if driver is not None]


@dataclass(frozen=True, eq=False)
class _DriverScreening:
    """Screening of drivers with the baseline's noise model, by curves of row means; unit (rows, q, 3)."""

    problem: LinearProblem
    coloured_baseline: ColouredBaseline
    unit: Array

    @classmethod
    def of(cls, baseline: Baseline) -> _DriverScreening:
        """Screen next to accepted effects and any course of time of the curves' order."""
        problem = baseline.problem
        unit = _unit(problem)
        coloured_baseline = ColouredBaseline.of(
            problem, (*baseline.accepted_columns, in_axes(unit, powers(_clock(problem), HIGHEST)))
        )
        return cls(problem, coloured_baseline, coloured_baseline.rows.bin(unit))

    def best(self, driver: Driver, ways: Sequence[Lag]) -> _ScreenedDriver:
        """The lag at which the curve of a driver gains most.

        A lag longer than the run makes the curve a sum over time: no run can show a driver behind it.
        """
        rows, interval_s = self.coloured_baseline.rows, self.problem.state.interval_s
        ways = [way for way in ways if way.lag_s < np.ptp(self.problem.state.time_s)]
        root = np.sqrt(np.maximum(rows.count, 1.0))[:, None]
        terms = [rows.bin(driver.terms(way, interval_s) * rows.usable[:, None]) / root for way in ways]
        nats = self.coloured_baseline.screening_gains([in_axes(self.unit, curve) for curve in terms])
        best = int(np.argmax(nats))
        return _ScreenedDriver(driver, ways[best], float(nats[best]))


def _unit(problem: LinearProblem) -> Array:
    """Response (n, q, 3) of the problem to one nT along each axis of the sensor."""
    return problem.sensor_axes(np.ones(len(problem.recording)))


def _clock(problem: LinearProblem) -> Array:
    """Time from -1 to 1 (n,)."""
    time_s = problem.state.time_s
    return np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1)


def _motion_drivers(problem: LinearProblem) -> list[Driver]:
    """Quantities of the motion outside the recorded channels."""
    recorded = {TIME, HEIGHT, *problem.state.channels}
    courses = [(name, x) for name, x in channels(problem) if name not in recorded]
    return [driver for name, x in courses if (driver := Driver.of(name, x, problem.policy)) is not None]


def _fit_curve(
    baseline: Baseline, coloured_baseline: ColouredBaseline, screened: _ScreenedDriver, known: int
) -> CandidateFit | None:
    """A driver's curve of the highest order with a noise model of its own."""
    candidate = screened.driver.candidate(screened.way, known * len(LAGS) * HIGHEST)
    evidence = judge_settings(baseline, [candidate])
    return (
        None
        if evidence is None
        else coloured_baseline.fit_candidate(evidence, coloured_baseline.rows.bin(candidate.columns(baseline.problem)))
    )


def _lowest_order(best: CandidateFit, coloured_baseline: ColouredBaseline, inflation: float) -> Candidate:
    """The curve of the lowest order that the data do not distinguish from the highest."""
    k = best.columns.shape[2] // HIGHEST
    held = [
        Hypothesis.with_noise_model(
            coloured_baseline.rows,
            coloured_baseline.columns_with(best.columns[:, :, : k * order]),
            best.hypothesis.noise_model,
        ).held_out_log_likelihood
        for order in range(1, HIGHEST + 1)
    ]
    near = max(held) - coloured_baseline.rows.policy.apart * inflation
    order = next(i for i, nats in enumerate(held, start=1) if nats >= near)
    return best.evidence.candidate.at({"order": order})


def _refined_lag(baseline: Baseline, candidate: Candidate) -> Candidate:
    """The curve with its lag interpolated between listed lags."""

    def misfit(curve: Candidate) -> float:
        sums = baseline.sums_with(curve.columns(baseline.problem))
        return squares(sums, fit(sums, baseline.all_folds), baseline.all_folds)

    finer = refine_between_neighbours(candidate, misfit)
    return (
        finer
        if finer is not None and misfit(candidate) - misfit(finer) > 2 * baseline.problem.policy.apart
        else candidate
    )


def channel_of(candidate: Candidate) -> str:
    """Name of the channel of a curve."""
    return str(dict(candidate.nonlinear)["channel"])
