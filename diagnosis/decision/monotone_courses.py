"""Monotone courses: a single recording cannot distinguish time and monotone channels."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import spearmanr

from diagnosis.evidence.localise import TIME, ChannelShare, channels, correlation, courses_on_within
from diagnosis.library.drivers import find_drivers
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import as_currents
from diagnosis.result import EvidenceKind, NamedEffect
from recordings.channels import current_name
from scenarios.arrays import Array
from sim.effects import BY_NAME
from validation.signals.amplitude import column_rms

Alike = Callable[[Array, Array], float]
"""(one course, another) -> how much of one the other has, 0 to 1."""


def with_rival_channels(problem: LinearProblem, cause: NamedEffect) -> NamedEffect:
    """Add the channels that may drive an effect equally well, where its course is monotone or has a window.

    Channels needed by the effect or its look-alikes are no rivals. An effect without a channel is a course of time; one
    with a window competes with the channels active in the window alone. For the current of a single motor, motors
    running alike are rivals too.
    """
    if cause.kind is not EvidenceKind.HELD_OUT:
        return cause
    needs = (cause.effect.needs, *(BY_NAME[name].needs for name in cause.alternatives))
    known = {need for each in needs for need in each or (TIME,)}
    currents = {current_name(motor) for motor in problem.state.motors}
    known |= {channel for channel in as_currents(problem.recording) if known & currents}
    window = cause.effect.active_s
    similar = courses_on_within(problem, window) if window else similar_channels(problem, cause)
    rivals = tuple(name for name in similar if name not in known)
    return replace(cause, rivals=(*rivals, *similar_motors(problem, cause)))


def similar_motors(problem: LinearProblem, cause: NamedEffect) -> tuple[str, ...]:
    """Channels of motors whose currents explain all of a named motor's current but an error of form.

    Empty where the sum of all currents is meant, or where each motor has a gain of its own. A tone of no motor is alike
    a tone of each motor whose current is steady, whether the library has such an effect or not.
    """
    role = cause.effect.with_role("motor")
    if role is not None:
        named = {getattr(effect, role) for effect in cause.effects if effect.name == cause.name}
        if len(named) > 1 or named == {0}:
            return ()
        (motor,) = named
        return _motors_like(problem, problem.state.channel(current_name(motor)), correlation, but=motor)
    listed = any(BY_NAME[name].with_role("motor") for name in cause.alternatives)
    is_tone = cause.effect.with_role("frequency") is not None
    return _motors_like(problem, np.ones(1), _cosine) if is_tone and not listed else ()


def _motors_like(problem: LinearProblem, course: Array, alike: Alike, but: int = 0) -> tuple[str, ...]:
    """Channels, or names, of the currents of all motors but one that are alike a course but for an error of form."""
    least = math.sqrt(1 - problem.policy.same_family)
    logged = {current: channel for channel, current in as_currents(problem.recording).items()}
    names = (current_name(motor) for motor in problem.state.motors if motor != but)
    return tuple(logged.get(name, name) for name in names if alike(course, problem.state.channel(name)) > least)


def similar_channels(problem: LinearProblem, cause: NamedEffect) -> tuple[str, ...]:
    """Time and the channels with the course of an effect's contribution; empty where the contribution rises and falls.

    Two courses agree where their rank correlation exceeds `nearly_all`: either is then a curve of the other. Channels
    that jump with a jump are rivals; in time the moment alone is known. Contributions that scale with the signal follow
    the turns of the sensor: their course is taken for a constant signal.
    """
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    jumps = cause.effect.search_role() == "moment"
    effects = [effect for effect in cause.effects if effect.name == cause.name]  # a second jump is a part of its course
    alike = correlation if jumps else _rank_correlation  # the ranks of levels are a matter of their noise
    courses = [(TIME, problem.state.time_s), *((driver.name, driver.x) for driver in find_drivers(problem))]
    for signal_nT in (problem.clean_nT, np.broadcast_to(column_rms(problem.clean_nT), problem.clean_nT.shape)):
        parts = [effect.contribution(problem.state, signal_nT, np.random.default_rng(0), {}) for effect in effects]
        added_nT = cut.means(np.sum(parts, axis=0))
        components, size, _ = np.linalg.svd(added_nT - added_nT.mean(axis=0), full_matrices=False)
        course = components[:, 0] * size[0]
        names = tuple(name for name, x in courses if alike(course, cut.means(x)) > problem.policy.nearly_all)
        if names and (jumps or TIME in names):
            return names
    return ()


def monotone_channels(problem: LinearProblem) -> frozenset[str]:
    """Time and all channels that only rise or fall during the run: a gap cannot distinguish them."""
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    time_s, least = cut.means(problem.state.time_s), problem.policy.nearly_all
    return frozenset(name for name, x in channels(problem) if _rank_correlation(time_s, cut.means(x)) > least)


def driving_channels(problem: LinearProblem, where: Sequence[ChannelShare]) -> list[str]:
    """Channels that a gap follows, by `where`, a little more than time; a monotone channel counts as time."""
    shares, slow = {share.channel: share.share for share in where}, monotone_channels(problem) | {TIME}
    least = shares.get(TIME, 0.0) + problem.policy.little
    return [name for name, share in shares.items() if share > least and name not in slow]


def _rank_correlation(first: Array, second: Array) -> float:
    """``|rho|`` of Spearman; 0 for a constant course."""
    return abs(float(spearmanr(first, second).statistic)) if np.ptp(first) > 0 and np.ptp(second) > 0 else 0.0


def _cosine(first: Array, second: Array) -> float:
    """``|cos|`` of the angle between courses, means included; 0 for a vanishing course."""
    size = float(np.sqrt((first**2).mean() * (second**2).mean()))
    return abs(float((first * second).mean())) / size if size > 0 else 0.0
