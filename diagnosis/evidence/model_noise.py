"""What the model itself says of slow errors: its own wander of the sensor, and the errors of its navigation."""

from __future__ import annotations

import numpy as np

from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_columns
from scenarios.arrays import Array
from validation.signals.bands import Bands


def as_stated(problem: LinearProblem, residual: Array) -> bool:
    """Whether a residual (n, q), in units of the noise, is no more than the slow errors that the model states.

    An attitude error turns the field, which leaves its strength alone: the part along the undisturbed field, with the
    nine columns of a strength fit taken off, must be white beside the model's own slow noises, and the part across
    must be as small as the stated error makes it. Without a stated attitude error every axis must be so.
    """
    if problem.attitude_std_rad == 0 or not problem.sees_across:
        return states_wander(problem) and _as_white_and_wander(problem, residual)
    if problem.level is not None:
        dip_nT = residual[:, 1:] * problem.sigma_nT[1:]
        return _as_white_and_wander(problem, residual[:, :1]) and _small_across(problem, dip_nT, angles=1)
    u, nT = problem.direction, (residual * problem.sigma_nT) @ np.linalg.inv(problem.turn).T
    along = (nT * u).sum(axis=1)
    across = nT - along[:, None] * u
    unit_nT = np.linalg.norm(problem.sees_along * problem.sigma_nT, axis=1)
    scaled = _without_strength(along / unit_nT, u, problem.usable)
    return _as_white_and_wander(problem, scaled[:, None]) and _small_across(problem, across)


def states_wander(problem: LinearProblem) -> bool:
    """Whether the model has a slow noise of its own."""
    return any(effect.traits.spectrum is not None for effect in problem.effects)


def _wander(problem: LinearProblem, f: Array) -> Array:
    """Power density (m,) of the model's own slow noises, mean over axes, in units of the noise."""
    total = np.zeros(len(f))
    for effect in problem.effects:
        shape, level = effect.traits.spectrum, effect.with_role("level")
        if shape is not None and level is not None:
            std = np.array(getattr(effect, level))
            total += float(((std / _noise_nT(problem)) ** 2).mean()) * shape(f)
    return total


def _noise_nT(problem: LinearProblem) -> Array:
    """Noise of the axes, or of the strength."""
    return problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]


def _as_white_and_wander(problem: LinearProblem, values: Array) -> bool:
    """Whether no band of a spectrum has more power than white noise and the stated wander give it."""
    policy, interval_s = problem.policy, problem.state.interval_s
    bands = Bands.of(values, interval_s, policy.first_line, policy.bands)
    expected = max(2 * interval_s, float(bands.power[-1])) + _wander(problem, bands.f)
    margin = policy.stated_margin if states_wander(problem) else 1.0
    return bool((bands.odds(bands.power / expected / margin) > policy.band_alarm / len(bands.f)).all())


def _without_strength(along: Array, u: Array, usable: Array) -> Array:
    design = strength_columns(u) * usable[:, None]
    return np.asarray(along - design @ np.linalg.lstsq(design, along, rcond=1e-9)[0])


def _small_across(problem: LinearProblem, across_nT: Array, angles: int = 2) -> bool:
    """Whether means of the part across the field are as small as the stated attitude error and the noise make them.

    angles : how many of the attitude's turn the field to what is seen of that part.
    """
    policy = problem.policy
    length = max(1, round(policy.slow_mean_s / problem.state.interval_s))
    means = Cut(length, len(across_nT) // length).means(across_nT)
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    turned = angles * (problem.attitude_std_rad * strength_nT) ** 2
    white = float((problem.sigma_nT[-across_nT.shape[1] :] ** 2).sum()) / length
    return bool((means**2).sum(axis=1).mean() < policy.stated_margin**2 * (turned + white))
