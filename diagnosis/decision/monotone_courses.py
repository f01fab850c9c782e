"""Courses that one recording cannot tell apart: what only rises or falls goes with time, and with all that does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.stats import spearmanr

from diagnosis.evidence.localise import TIME, channels
from diagnosis.evidence.smooth_windows import correlation, on_within
from diagnosis.library.drivers import drivers
from diagnosis.problem.actuators import as_currents
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import How, Named
from recordings.channels import current_name
from scenarios.arrays import Array
from sim.effects import BY_NAME
from validation.signals.amplitude import column_rms


def with_rivals(problem: LinearProblem, one: Named) -> Named:
    """A name with the channels that drive it as well: where what it adds only rises or falls, or has a window.

    Those that it or its look-alikes need are no rivals. An effect that needs no channel is itself a course of time. Of
    one motor's current they are also those of motors that run alike.
    """
    if one.how is not How.HELD_OUT:
        return one
    needs = (one.effect.needs, *(BY_NAME[name].needs for name in one.alternatives))
    known = {need for each in needs for need in each or (TIME,)}
    currents = {current_name(motor) for motor in problem.state.motors}
    known |= {channel for channel in as_currents(problem.recording) if known & currents}
    rivals = tuple(name for name in channels_alike(problem, one) if name not in known)
    return replace(one, rivals=(*rivals, *motors_alike(problem, one)))


def motors_alike(problem: LinearProblem, one: Named) -> tuple[str, ...]:
    """Channels of motors whose currents explain all of another's but an error of form, of which one is told apart.

    None where the sum of all is meant, or where each has a gain of its own.
    """
    role = one.effect.with_role("motor")
    told = {getattr(effect, role) for effect in one.effects if effect.name == one.name} if role else {0}
    if len(told) > 1 or told == {0}:
        return ()
    (motor,), least = told, math.sqrt(1 - problem.policy.same_kin)
    current_A = problem.state.channel(current_name(motor))
    logged = {current: channel for channel, current in as_currents(problem.recording).items()}
    others = (current_name(other) for other in problem.state.motors if other != motor)
    return tuple(
        logged.get(name, name) for name in others if correlation(current_A, problem.state.channel(name)) > least
    )


def channels_alike(problem: LinearProblem, one: Named) -> tuple[str, ...]:
    """Time and the channels with the same course as what an effect adds; none where it rises and falls.

    Beside a jump those that jump with it: in time only that moment speaks for it. Courses are one where their rank
    correlation is above `one_course`: one is then a curve of the other. What scales with the signal comes and goes as
    the sensor turns: of it the course is that beside a signal that stands. Of what acts in a part of the run it is the
    channels that are on in that part alone.
    """
    if one.effect.active_s is not None:
        return on_within(problem, one.effect.active_s)
    standing_nT = np.broadcast_to(column_rms(problem.clean_nT), problem.clean_nT.shape)
    several = (_alike_beside(problem, one, signal_nT) for signal_nT in (problem.clean_nT, standing_nT))
    return next((names for names in several if names), ())


def _alike_beside(problem: LinearProblem, one: Named, signal_nT: Array) -> tuple[str, ...]:
    """The same beside a signal (n, 3)."""
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    same = [effect for effect in one.effects if effect.name == one.name]  # a second jump is a part of its course
    parts = [effect.contribution(problem.state, signal_nT, np.random.default_rng(0), {}) for effect in same]
    course, jumps = _main_course(cut.means(np.sum(parts, axis=0))), one.effect.search_role() == "moment"
    alike = correlation if jumps else _rank_correlation  # the ranks of levels are a matter of their noise
    names = [name for name, x in _courses(problem) if alike(course, cut.means(x)) > problem.policy.one_course]
    return tuple(names) if jumps or TIME in names else ()


def channels_of_time(problem: LinearProblem) -> frozenset[str]:
    """Time, and the channels that only rise or fall in the run: no gap tells these from it."""
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    time_s, least = cut.means(problem.state.time_s), problem.policy.one_course
    return frozenset(name for name, x in channels(problem) if _rank_correlation(time_s, cut.means(x)) > least)


def _courses(problem: LinearProblem) -> Iterator[tuple[str, Array]]:
    yield TIME, problem.state.time_s
    yield from ((one.name, one.x) for one in drivers(problem))


def _main_course(added_nT: Array) -> Array:
    """The first principal component (m,) of a course (m, 3)."""
    left, size, _ = np.linalg.svd(added_nT - added_nT.mean(axis=0), full_matrices=False)
    return np.asarray(left[:, 0] * size[0])


def _rank_correlation(one: Array, other: Array) -> float:
    """``|rho|`` of Spearman; 0 for a course that stands."""
    return abs(float(spearmanr(one, other).statistic)) if np.ptp(one) > 0 and np.ptp(other) > 0 else 0.0
