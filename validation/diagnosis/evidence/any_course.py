"""A slow disturbance that an effect follows for a part of its way: a smooth course of time follows it better."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim.effects.channels import HIGHEST, ChannelEffect, powers
from sim.state import Array
from validation.diagnosis.evidence.standing import Beside, Standing
from validation.diagnosis.library.drivers import in_axes
from validation.diagnosis.problem.linear import LinearProblem


def a_course_of_time_does_better(one: Standing, beside: Beside, problem: LinearProblem) -> bool:
    """Whether any course of time of the third order gains more than an effect, which is of no use beside it.

    More by the part of the evidence within which two look alike. Noise that is steeper than a rest's processes is a
    smooth course of the run; what only rises follows it in part, and no rest takes that up. But it has a course of its
    own on each axis: where all have one, that is a cause, of another form. Without attitude: False.
    """
    policy = problem.policy
    if problem.mode != "vector":
        return False
    free = replace(one.evidence, candidate=replace(one.evidence.candidate, tried=1))
    course = beside.standing(free, beside.rows.taken(_courses(problem)))
    more = course.gain - one.gain
    if more < max(policy.apart, policy.same_coloured * course.gain):
        return False
    if _of_one_course(course) > policy.one_cause:
        return False
    return bool(beside.left_of(one, course) < policy.look_alike_left)


def _of_one_course(course: Standing) -> float:
    """Share of the power of what courses (n, q, k) add that one course makes on all axes."""
    k = course.columns.shape[2]
    added = course.columns @ course.hypothesis.c[-k:]
    power = np.linalg.svd(added - added.mean(axis=0), compute_uv=False) ** 2
    return float(power[0] / power.sum())


def _courses(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of the powers of time along each axis of the sensor."""
    time_s = problem.state.time_s
    x = np.asarray(2 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1, dtype=np.float64)
    axes = problem.whitened(np.tile(np.eye(3), (len(x), 1, 1)), ChannelEffect)
    return in_axes(axes, powers(x, HIGHEST))
