"""A slow disturbance that an effect follows for a part of its way: a smooth course of time follows it better."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.library.drivers import in_axes
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.channels import HIGHEST, ChannelEffect, powers
from sim.effects.earth import RegionalField


def a_course_of_time_does_better(one: CandidateFit, beside: ColouredBaseline, problem: LinearProblem) -> bool:
    """Whether any course of time of the third order gains more than an effect, which is of no use beside it.

    More by the part of the evidence within which two look alike. Noise that is steeper than a rest's processes is a
    smooth course of the run; what only rises follows it in part, and no rest takes that up. But it has a course of its
    own on each axis: where all have one, that is a cause, of another form. Without attitude: False.
    """
    if problem.mode != "vector":
        return False
    course = _free(one, beside, _courses(problem))
    return _does_better(course, one, beside) and _of_one_course(course) <= problem.policy.one_cause


def a_course_of_the_field_does_better(one: CandidateFit, beside: ColouredBaseline, problem: LinearProblem) -> bool:
    """The same of any course along the earth's axes, of an effect that is no field of its own nor an attitude's error.

    A field that changes turns as the vehicle does, which no rest of the sensor's axes takes up.
    """
    traits = one.evidence.candidate.effect.traits
    if problem.mode != "vector" or not problem.sees_across or traits.field_source or traits.attitude_error:
        return False
    course = _free(one, beside, _courses_of_the_field(problem))
    return _does_better(course, one, beside)


def a_course_of_the_place_does_better(one: CandidateFit, beside: ColouredBaseline, problem: LinearProblem) -> bool:
    """The same of any field that is linear in the place, of an effect that is a field which changes in time.

    A vehicle that moves on meets the field of places one after the other.
    """
    effect = one.evidence.candidate.effect
    in_time = effect.traits.field_source and "position" not in effect.needs
    if problem.mode != "vector" or "position" not in problem.has or not in_time:
        return False
    return _does_better(_free(one, beside, _courses_of_the_place(problem)), one, beside)


def _free(one: CandidateFit, beside: ColouredBaseline, courses: Array) -> CandidateFit:
    """Courses (n, q, k) beside a rest of their own, in place of a candidate, without the price of its search."""
    free = replace(one.evidence, candidate=replace(one.evidence.candidate, tried=1))
    return beside.standing(free, beside.rows.taken(courses))


def _does_better(course: CandidateFit, one: CandidateFit, beside: ColouredBaseline) -> bool:
    """Whether a course gains more than look-alikes differ by, and a candidate is of no use beside it."""
    policy = beside.rows.policy
    if course.gain - one.gain < max(policy.apart, policy.same_coloured * course.gain):
        return False
    return bool(beside.left_of(one, course) < policy.look_alike_left)


def _of_one_course(course: CandidateFit) -> float:
    """Share of the power of what courses (n, q, k) add that one course makes on all axes."""
    k = course.columns.shape[2]
    added = course.columns @ course.hypothesis.c[-k:]
    power = np.linalg.svd(added - added.mean(axis=0), compute_uv=False) ** 2
    return float(power[0] / power.sum())


def _courses(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of the powers of time along each axis of the sensor."""
    x = _clock(problem)
    axes = problem.whitened(np.tile(np.eye(3), (len(x), 1, 1)), ChannelEffect)
    return in_axes(axes, powers(x, HIGHEST))


def _courses_of_the_field(problem: LinearProblem) -> Array:
    """The same along east, north and up, with a constant."""
    x = _clock(problem)
    axes = problem.whitened(problem.state.R_wb.transpose(0, 2, 1), RegionalField)
    return in_axes(axes, np.column_stack([np.ones(len(x)), powers(x, HIGHEST)]))


def _courses_of_the_place(problem: LinearProblem) -> Array:
    """A constant and the place, from the middle of the way, along east, north and up."""
    way = problem.state.pos_enu_m - problem.state.pos_enu_m.mean(axis=0)
    axes = problem.whitened(problem.state.R_wb.transpose(0, 2, 1), RegionalField)
    return in_axes(axes, np.column_stack([np.ones(len(way)), way / max(float(np.abs(way).max()), 1.0)]))


def _clock(problem: LinearProblem) -> Array:
    """Time (n,) from -1 at the start to 1 at the end."""
    time_s = problem.state.time_s
    return np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1, dtype=np.float64)
