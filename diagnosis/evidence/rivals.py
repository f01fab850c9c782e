"""Explanations without a name, with which every effect of the library competes by one measure.

A rival is a group of columns, fitted like a candidate: with a noise model of its own, judged by the nats it gains on
held-out folds. `RIVALS` lists them; a wandering attitude is a rival by its noise model, without columns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, gain_within
from diagnosis.evidence.hypothesis import in_sample_gains
from diagnosis.evidence.localise import TIME, courses_on_within, lagged_terms
from diagnosis.library.candidates import Candidate, attitude_turns
from diagnosis.library.drivers import AT_ONCE, Driver, find_drivers, in_axes
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers
from sim.effects.parameters import ACTIVE_WINDOW

ATTITUDE_WANDER = "explained equally well by a slowly wandering attitude"
SIZE_DIFFERS = "the size differs between parts of the run"
SIZE_FOLLOWS = "explained equally well by a size that follows {}"


class Rival(NamedTuple):
    """An explanation without a name: its words in a refusal, and its columns (N, q, k).

    equal : it explains the same data by a simpler cause, and wins a tie; other rivals must lead by more than the form
    error of an effect. own_ways : it counts only where its axes go their own ways, as noise does.
    """

    words: str
    columns: Array
    equal: bool = False
    own_ways: bool = False

    def leads(self, gain: float, own: float, policy: Policy) -> bool:
        """Whether the rival's nats lead a candidate's own, or tie with them where the rival is simpler."""
        return gain >= own + (-policy.apart if self.equal else max(policy.apart, policy.same_coloured * gain))


def winning_rivals(fit: CandidateFit, baseline: Baseline, beside: ColouredBaseline, *, coloured: bool) -> Iterator[str]:
    """The words of the rivals that explain more than a fitted candidate and leave it no use, the best first.

    baseline, beside : without the candidate. coloured : whether the candidate leaves a coloured residual; only then are
    smooth courses tried.
    """
    tables = (*RIVALS, *(SLOW_RIVALS if coloured else ()))
    tried = [rival for rivals in tables for rival in rivals(beside.problem, fit.evidence.candidate)]
    groups = [*(beside.rows.bin(rival.columns) for rival in tried), fit.columns]
    *gains, own = in_sample_gains(beside.rows, beside.accepted_columns, groups, fit.hypothesis.noise_model)
    # in sample, a first look at a tenth of the price
    policy = beside.rows.policy
    likely = (rival for rival, gain in zip(tried, gains, strict=True) if rival.leads(gain, own, policy))
    fitted = sorted(
        ((_fitted(rival.columns, fit, baseline, beside), rival) for rival in likely), key=lambda one: -one[0].gain
    )
    for other, rival in fitted:
        if rival.leads(other.gain, fit.gain, policy) and _suffices(rival, other, fit, beside):
            yield rival.words


def _fitted(columns: Array, fit: CandidateFit, baseline: Baseline, beside: ColouredBaseline) -> CandidateFit:
    """Columns (N, q, k) fitted in place of a candidate, without the price of its search."""
    free = replace(fit.evidence, candidate=replace(fit.evidence.candidate, tried=1))
    return beside.fit_candidate(free, beside.rows.bin(columns), gain_within(baseline, beside.rows, columns))


def _suffices(rival: Rival, other: CandidateFit, fit: CandidateFit, beside: ColouredBaseline) -> bool:
    """Whether a fitted rival leaves a candidate no use, and its axes go their own ways where this counts."""
    own_ways = not rival.own_ways or _of_one_course(other) <= beside.rows.policy.one_cause
    return own_ways and beside.remaining_share(fit, other) < beside.rows.policy.half


def _of_one_course(course: CandidateFit) -> float:
    """Largest share of the power of fitted columns (n, q, k) that a single time course makes on all axes."""
    added = course.columns @ course.hypothesis.c[-course.columns.shape[2] :]
    power = np.linalg.svd(added - added.mean(axis=0), compute_uv=False) ** 2
    return float(power[0] / power.sum())


def lobe_of_the_heading(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A tone of frequency f along ``k psi(t)`` in place of ``2 pi f t``, k the integer nearest to f over the turn rate.

    In an even turn iron of the vehicle makes such tones.
    """
    angle = _angle_of_tone(problem, candidate)
    if angle is None:
        return
    R = problem.state.R_wb
    heading = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
    turn = float(np.median(np.abs(np.diff(heading))))
    lobes = round(float(np.median(np.abs(np.diff(angle)))) / turn) if turn > 0 else 0
    if 1 <= lobes <= problem.policy.most_lobes:
        sine, cosine = np.split(candidate.columns(problem), 2, axis=2)
        ahead = lobes * heading - angle
        c, s = (part[:, None, None] for part in (np.cos(ahead), np.sin(ahead)))
        turned = np.concatenate([sine * c + cosine * s, cosine * c - sine * s], axis=2)
        yield Rival("explained equally well by a function of the heading", turned, equal=True)


def wave_of_the_field(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A tone along the Earth's axes, as of swell or pulsations, in place of a tone of a current."""
    angle = _angle_of_tone(problem, candidate)
    if angle is not None:
        swing = in_axes(problem.earth_axes(), np.column_stack([np.sin(angle), np.cos(angle)]))
        yield Rival("explained better by a wave of the field in the earth's frame", swing)


def _angle_of_tone(problem: LinearProblem, candidate: Candidate) -> Array | None:
    """``2 pi f t`` (n,) of a candidate with a frequency and a free phase; None for others, and without attitude."""
    name = candidate.effect.with_role("frequency")
    if name is None or candidate.phase is None or problem.mode != "vector":
        return None
    return np.asarray(2 * np.pi * float(dict(candidate.nonlinear)[name]) * problem.state.time_s)


def size_that_follows(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A candidate with a window whose size follows time, or a channel at once or with a lag, in the whole run instead.

    A channel that is on in the window alone is the window by another name, and must lead.
    """
    if candidate.window is None:
        return
    alike = courses_on_within(problem, candidate.window)
    plain = candidate.at({ACTIVE_WINDOW.name: None}).columns(problem)
    for name, terms in _courses(problem):
        grown = np.concatenate([plain, *(plain * term[:, None, None] for term in terms.T)], axis=2)
        yield Rival(SIZE_FOLLOWS.format(name), grown, equal=name not in alike)


def _courses(problem: LinearProblem) -> Iterator[tuple[str, Array]]:
    """Names and terms (n, j): the powers of time, and every channel with each lag."""
    interval_s, time = problem.state.interval_s, Driver.of(TIME, problem.state.time_s, problem.policy)
    if time is not None:
        yield TIME, time.terms(AT_ONCE, interval_s)
    for driver in find_drivers(problem):
        yield from ((driver.name, terms[:, :1]) for terms in lagged_terms(problem, driver))


def size_of_each_part(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """The candidate with a size of its own in each quarter of the run: the coefficients of a true effect are equal."""
    columns, n = candidate.columns(problem), len(problem.recording)
    parts = np.arange(n) * problem.policy.scatter_parts // n
    each = [columns * (parts == part)[:, None, None] for part in range(parts[-1] + 1)]
    acting = [part for part in each if part.any()]
    if len(acting) > 1:
        yield Rival(SIZE_DIFFERS, np.concatenate(acting, axis=2))


def course_of_time(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A cubic of time on each axis: noise steeper than a noise model's processes, followed by any monotone effect."""
    if problem.mode == "vector":
        unit, x = problem.sensor_axes(np.ones(len(problem.recording))), _clock(problem)
        yield Rival("explained better by a smooth course of time", in_axes(unit, powers(x, HIGHEST)), own_ways=True)


def course_of_the_field(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A cubic of time along the Earth's axes, which no noise of the sensor's axes describes."""
    traits = candidate.effect.traits
    if problem.along_attitude and not (traits.field_source or traits.attitude_error):
        terms = np.column_stack([np.ones(len(problem.recording)), powers(_clock(problem), HIGHEST)])
        yield Rival("explained better by a smooth course of the field", in_axes(problem.earth_axes(), terms))


def course_of_the_place(problem: LinearProblem, candidate: Candidate) -> Iterator[Rival]:
    """A field linear in position, which a vehicle that moves on sees as one that changes in time."""
    effect = candidate.effect
    in_time = effect.traits.field_source and "position" not in effect.needs
    if problem.mode == "vector" and "position" in problem.inputs and in_time:
        way = problem.state.pos_enu_m - problem.state.pos_enu_m.mean(axis=0)
        terms = np.column_stack([np.ones(len(way)), way / max(float(np.abs(way).max()), 1.0)])
        yield Rival("explained better by a field that changes with position", in_axes(problem.earth_axes(), terms))


def _clock(problem: LinearProblem) -> Array:
    """Time (n,) scaled from -1 at the start to 1 at the end."""
    time_s = problem.state.time_s
    return np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1, dtype=np.float64)


Rivals = Callable[[LinearProblem, Candidate], Iterator[Rival]]
RIVALS: tuple[Rivals, ...] = (lobe_of_the_heading, wave_of_the_field, size_that_follows, size_of_each_part)
SLOW_RIVALS: tuple[Rivals, ...] = (course_of_time, course_of_the_field, course_of_the_place)
"""Rivals where a candidate leaves a coloured residual."""


def attitude_suffices(fit: CandidateFit, baseline: Baseline, beside: ColouredBaseline) -> bool:
    """Whether an attitude error that is constant or grows with powers of time explains as much as a candidate field."""
    problem = beside.problem
    if problem.mode != "vector" or problem.relative:
        return False
    turns = attitude_turns(problem)
    x = (_clock(problem) + 1) / 2
    growing = np.concatenate([turns * (x**j)[:, None, None] for j in range(HIGHEST + 1)], axis=2)
    return _fitted(growing, fit, baseline, beside).gain > fit.gain - beside.rows.policy.apart


def with_attitude_wander(beside: ColouredBaseline) -> ColouredBaseline | None:
    """The coloured baseline with a noise model of sensor axes and of three attitude angles.

    On the sensor's axes a slow attitude error is modulated by the motion, which no noise model of the axes alone
    describes. None where the motion does not turn the sensor.
    """
    if not beside.problem.turns:
        return None
    turns = beside.rows.bin(attitude_turns(beside.problem))
    together = replace(beside.rows.in_common(), output_axes=turns / np.sqrt((turns**2).mean()))
    return ColouredBaseline.in_rows(beside.problem, together, beside.accepted_columns)


def wander_wins(fit: CandidateFit, wander: ColouredBaseline | None, needed: float) -> bool:
    """Whether a wandering attitude is likelier than a candidate, and leaves it less than the needed nats."""
    if wander is None or wander.hypothesis.log_likelihood < fit.hypothesis.log_likelihood + wander.rows.policy.apart:
        return False
    return wander.fit_candidate(fit.evidence, fit.columns, fit.within).gain <= needed
