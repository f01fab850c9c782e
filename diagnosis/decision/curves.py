"""The last resort: curves of recorded channels, where no effect of the library stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.selection import residual_tests
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, look_alikes
from diagnosis.evidence.held_out import Evidence, judged_at
from diagnosis.evidence.hypothesis import Hypothesis
from diagnosis.evidence.localise import TIME, channels
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, EARLY, WAYS, Driver, Way, drivers, in_axes
from diagnosis.library.parameter_search import between_neighbours
from diagnosis.problem.blocks import fit, squares
from diagnosis.problem.linear import LinearProblem
from recordings.channels import HEIGHT
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, ChannelEffect, powers


@dataclass(frozen=True)
class Curve:
    """An accepted curve of a channel, and the channels that do as well."""

    evidence: Evidence
    rivals: tuple[str, ...]

    @property
    def candidate(self) -> Candidate:
        """Its channel, lag and order."""
        return self.evidence.candidate

    @property
    def channel(self) -> str:
        """The channel's name."""
        return channel_of(self.candidate)


@dataclass(frozen=True, eq=False)
class _FeltDriver:
    """A driver as it is best felt, and the nats of a first look."""

    driver: Driver
    way: Way
    nats: float


def curves(start: Baseline, ground: Baseline | None = None) -> tuple[Curve, ...]:
    """Curves of channels one after the other, each of which beats a slow rest beside any course of time of its order.

    Motion is a rival: where a curve of the field, a rate, an angle or a place explains more, what drives the gap is no
    channel. start : the ground without any effect, of whose gap a curve must explain a share; ground : that with those
    that they are looked for beside, if any.
    """
    problem, ground, found = start.problem, ground or start, list[Curve]()
    known = drivers(problem)
    while known and len(found) < problem.policy.most_curves and not (found and residual_tests(ground, ()).clean):
        chosen = _next(ground, start, known, first=not found)
        if chosen is None:
            break
        found.append(chosen)
        known = [one for one in known if one.name != chosen.channel]
        ground = ground.beside(chosen.candidate.columns(problem))
    return tuple(found)


def _next(ground: Baseline, start: Baseline, known: Sequence[Driver], *, first: bool) -> Curve | None:
    """The best curve of those that stand; one beside others need add less."""
    policy = ground.problem.policy
    look = _Look.of(ground)
    tried = _tried(ground, look, known)
    for best in sorted(tried, key=lambda one: -one.gain):
        by_chance = look.beside.surrogates(best, ground.problem)
        inflation = max(1.0, 2 * float(by_chance.mean()) / best.columns.shape[2])
        if best.gain / inflation <= policy.coloured_nats or best.gain <= by_chance.max():
            continue
        chosen = judged_at(ground, [_finer(ground, _simpler(best, look.beside, inflation))])
        if chosen is None or _adds(start, ground, chosen) < (policy.least_share if first else policy.least_added):
            continue
        others = [one for one in tried if one is not best]
        alike = look_alikes(best, others, look.beside, policy.apart * inflation, policy.same_coloured)
        judged = replace(chosen, gain=best.gain, V=inflation)
        return Curve(judged, tuple(channel_of(one.evidence.candidate) for one in alike))
    return None


def _adds(start: Baseline, ground: Baseline, chosen: Evidence) -> float:
    return added_share(start, ground, ground.beside(chosen.candidate.columns(ground.problem)).squares)


def _tried(ground: Baseline, look: _Look, known: Sequence[Driver]) -> list[CandidateFit]:
    """The best channels of a first look, each beside a rest of its own; none where a motion does better than all."""
    policy = ground.problem.policy
    seen = sorted((look.best(one, EARLY) for one in known), key=lambda one: -one.nats)[: policy.tried_coloured]
    rival = max((look.best(one, (AT_ONCE,)).nats for one in _motion(ground.problem)), default=0.0)
    if seen[0].nats <= max(rival, policy.coloured_nats):
        return []
    standing = [_standing(ground, look.beside, look.best(one.driver, WAYS), len(known)) for one in seen]
    return [one for one in standing if one is not None]


@dataclass(frozen=True, eq=False)
class _Look:
    """A first look at drivers: curves of row means, beside the rest as it is; unit (rows, q, 3)."""

    problem: LinearProblem
    beside: ColouredBaseline
    unit: Array

    @classmethod
    def of(cls, ground: Baseline) -> _Look:
        """Beside the effects that are in, and any course of time of the curves' order."""
        problem = ground.problem
        unit = _unit(problem)
        beside = ColouredBaseline.of(problem, (*ground.inside, in_axes(unit, powers(_clock(problem), HIGHEST))))
        return cls(problem, beside, beside.rows.taken(unit))

    def best(self, driver: Driver, ways: Sequence[Way]) -> _FeltDriver:
        """The way of feeling a driver in which its curve gains most.

        What is felt later than the run is long has the course of a sum over time: no run shows that a driver makes it.
        """
        rows, interval_s = self.beside.rows, self.problem.state.interval_s
        ways = [way for way in ways if way.lag_s < np.ptp(self.problem.state.time_s)]
        root = np.sqrt(np.maximum(rows.count, 1.0))[:, None]
        terms = [rows.taken(driver.terms(way, interval_s) * rows.usable[:, None]) / root for way in ways]
        nats = self.beside.roughly([in_axes(self.unit, one) for one in terms])
        best = int(np.argmax(nats))
        return _FeltDriver(driver, ways[best], float(nats[best]))


def _unit(problem: LinearProblem) -> Array:
    """What one nT along each axis of the sensor is in the problem (n, q, 3)."""
    axes = np.tile(np.eye(3), (len(problem.recording), 1, 1))
    return problem.whitened(axes, ChannelEffect)


def _clock(problem: LinearProblem) -> Array:
    """Time from -1 to 1 (n,)."""
    time_s = problem.state.time_s
    return np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1)


def _motion(problem: LinearProblem) -> list[Driver]:
    """What moves and is no recorded channel."""
    told = {TIME, HEIGHT, *problem.state.channels}
    courses = [(name, x) for name, x in channels(problem) if name not in told]
    return [one for name, x in courses if (one := Driver.of(name, x, problem.policy)) is not None]


def _standing(ground: Baseline, beside: ColouredBaseline, seen: _FeltDriver, known: int) -> CandidateFit | None:
    """A driver's curve of the highest order beside a rest of its own."""
    candidate = seen.driver.candidate(seen.way, known * len(WAYS) * HIGHEST)
    evidence = judged_at(ground, [candidate])
    return None if evidence is None else beside.standing(evidence, beside.rows.taken(candidate.columns(ground.problem)))


def _simpler(best: CandidateFit, beside: ColouredBaseline, inflation: float) -> Candidate:
    """The curve of the lowest order that the data do not tell from the highest."""
    k = best.columns.shape[2] // HIGHEST
    held = [
        Hypothesis.given(beside.rows, beside.joined(best.columns[:, :, : k * order]), best.hypothesis.rest).held
        for order in range(1, HIGHEST + 1)
    ]
    near = max(held) - beside.rows.policy.apart * inflation
    order = next(i for i, nats in enumerate(held, start=1) if nats >= near)
    return best.evidence.candidate.at({"order": order})


def _finer(ground: Baseline, candidate: Candidate) -> Candidate:
    """The curve with its lag moved between its neighbours in the list."""

    def misfit(one: Candidate) -> float:
        sums = ground.joined(one.columns(ground.problem))
        return squares(sums, fit(sums, ground.everything), ground.everything)

    finer = between_neighbours(candidate, misfit)
    return (
        finer
        if finer is not None and misfit(candidate) - misfit(finer) > 2 * ground.problem.policy.apart
        else candidate
    )


def channel_of(candidate: Candidate) -> str:
    """The channel of a curve."""
    return str(dict(candidate.nonlinear)["channel"])
