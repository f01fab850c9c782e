"""Smooth courses of time, field or place as rivals of an effect that follows a slow disturbance only in part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.library.drivers import in_axes
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, powers


def time_course_explains_more(
    candidate: CandidateFit, coloured_baseline: ColouredBaseline, problem: LinearProblem
) -> bool:
    """Whether a cubic of time on each axis gains more than a candidate, and leaves the candidate no use.

    The margin is the share of evidence within which candidates are look-alikes. Noise steeper than the processes of the
    noise model is a smooth course, followed in part by any monotone effect. A course common to all axes has a single
    cause of unknown form, and does not count as noise. False without attitude.
    """
    if problem.mode != "vector":
        return False
    course = _free(candidate, coloured_baseline, _courses(problem))
    return _does_better(course, candidate, coloured_baseline) and _of_one_course(course) <= problem.policy.one_cause


def field_course_explains_more(
    candidate: CandidateFit, coloured_baseline: ColouredBaseline, problem: LinearProblem
) -> bool:
    """Whether a cubic of time in Earth's axes gains more than a candidate that is no field or attitude error.

    A changing field rotates in the sensor frame with the vehicle; a noise model of the sensor axes does not describe
    the modulation.
    """
    traits = candidate.evidence.candidate.effect.traits
    if problem.mode != "vector" or not problem.compares_across or traits.field_source or traits.attitude_error:
        return False
    course = _free(candidate, coloured_baseline, _courses_of_the_field(problem))
    return _does_better(course, candidate, coloured_baseline)


def place_course_explains_more(
    candidate: CandidateFit, coloured_baseline: ColouredBaseline, problem: LinearProblem
) -> bool:
    """Whether a field linear in position gains more than a candidate field that changes with time.

    A vehicle that moves on sees the spatial field as a course of time.
    """
    effect = candidate.evidence.candidate.effect
    in_time = effect.traits.field_source and "position" not in effect.needs
    if problem.mode != "vector" or "position" not in problem.inputs or not in_time:
        return False
    return _does_better(
        _free(candidate, coloured_baseline, _courses_of_the_place(problem)), candidate, coloured_baseline
    )


def _free(candidate: CandidateFit, coloured_baseline: ColouredBaseline, courses: Array) -> CandidateFit:
    """Columns (n, q, k) fitted with their own noise model, in place of a candidate, without search price."""
    free = replace(candidate.evidence, candidate=replace(candidate.evidence.candidate, tried=1))
    return coloured_baseline.fit_candidate(free, coloured_baseline.rows.bin(courses))


def _does_better(course: CandidateFit, candidate: CandidateFit, coloured_baseline: ColouredBaseline) -> bool:
    """Whether a course gains more than the margin of look-alikes, and leaves the candidate no use."""
    policy = coloured_baseline.rows.policy
    if course.gain - candidate.gain < max(policy.apart, policy.same_coloured * course.gain):
        return False
    return bool(coloured_baseline.remaining_share(candidate, course) < policy.look_alike_kept)


def _of_one_course(course: CandidateFit) -> float:
    """Largest share of the power of fitted columns (n, q, k) that a single time course makes on all axes."""
    k = course.columns.shape[2]
    added = course.columns @ course.hypothesis.c[-k:]
    power = np.linalg.svd(added - added.mean(axis=0), compute_uv=False) ** 2
    return float(power[0] / power.sum())


def _courses(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of the powers of time along each sensor axis."""
    x = _clock(problem)
    return in_axes(problem.sensor_axes(np.ones(len(x))), powers(x, HIGHEST))


def _courses_of_the_field(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of a constant and the powers of time along east, north and up."""
    x = _clock(problem)
    return in_axes(problem.earth_axes(), np.column_stack([np.ones(len(x)), powers(x, HIGHEST)]))


def _courses_of_the_place(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of a constant and the position, from the mean position, along east, north and up."""
    way = problem.state.pos_enu_m - problem.state.pos_enu_m.mean(axis=0)
    return in_axes(problem.earth_axes(), np.column_stack([np.ones(len(way)), way / max(float(np.abs(way).max()), 1.0)]))


def _clock(problem: LinearProblem) -> Array:
    """Time (n,) scaled from -1 at the start to 1 at the end."""
    time_s = problem.state.time_s
    return np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1, dtype=np.float64)
