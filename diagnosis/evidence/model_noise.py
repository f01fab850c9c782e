"""Slow errors stated by the model: wander of the sensor, and attitude errors of navigation."""

from __future__ import annotations

import numpy as np

from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_columns
from scenarios.arrays import Array
from validation.signals.bands import Bands


def within_stated_errors(problem: LinearProblem, residual: Array) -> bool:
    """Whether a residual (n, q), in units of the noise, is no larger than the slow errors stated by the model.

    An attitude error turns the field and keeps the field's strength. The part along the field, with the nine columns of
    a strength fit projected out, must be white noise plus the stated wander; the part across the field must be no
    larger than the stated attitude error. Without a stated attitude error the first condition holds for every axis.
    """
    if problem.attitude_std_rad == 0 or not problem.compares_across:
        return states_slow_noise(problem) and _as_white_and_wander(problem, residual)
    if problem.level is not None:
        dip_nT = residual[:, 1:] * problem.sigma_nT[1:]
        return _as_white_and_wander(problem, residual[:, :1]) and _small_across(problem, dip_nT, angles=1)
    u, nT = problem.direction, (residual * problem.sigma_nT) @ np.linalg.inv(problem.turn).T
    along = (nT * u).sum(axis=1)
    across = nT - along[:, None] * u
    unit_nT = np.linalg.norm(problem.field_projection * problem.sigma_nT, axis=1)
    scaled = _without_strength(along / unit_nT, u, problem.usable)
    return _as_white_and_wander(problem, scaled[:, None]) and _small_across(problem, across)


def states_slow_noise(problem: LinearProblem) -> bool:
    """Whether the model has an effect of slow noise."""
    return any(effect.traits.spectrum is not None for effect in problem.effects)


def _wander(problem: LinearProblem, f: Array) -> Array:
    """Power density (m,) of the model's slow noise at frequencies f (m,), averaged over axes, in units of the noise."""
    total = np.zeros(len(f))
    for effect in problem.effects:
        shape, level = effect.traits.spectrum, effect.with_role("level")
        if shape is not None and level is not None:
            std = np.array(getattr(effect, level))
            listed = {name: getattr(effect, name) for name in effect.search}
            total += float(((std / _noise_nT(problem)) ** 2).mean()) * shape(f, problem.state.interval_s, **listed)
    return total


def _noise_nT(problem: LinearProblem) -> Array:
    """Noise in nT of the axes, or of the strength."""
    return problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]


def _as_white_and_wander(problem: LinearProblem, values: Array) -> bool:
    """Whether no band of the spectrum exceeds white noise plus the stated wander."""
    policy, interval_s = problem.policy, problem.state.interval_s
    bands = Bands.of(values, interval_s, policy.first_line, policy.bands)
    expected = max(2 * interval_s, float(bands.power[-1])) + _wander(problem, bands.f)
    margin = policy.somewhat_larger if states_slow_noise(problem) else 1.0
    return bool((bands.odds(bands.power / expected / margin) > policy.test_alarm / len(bands.f)).all())


def _without_strength(along: Array, u: Array, usable: Array) -> Array:
    design = strength_columns(u) * usable[:, None]
    return np.asarray(along - design @ np.linalg.lstsq(design, along, rcond=1e-9)[0])


def _small_across(problem: LinearProblem, across_nT: Array, angles: int = 2) -> bool:
    """Whether means of the part across the field are as small as the stated attitude error and the noise.

    angles : number of attitude angles that turn the field in the observed plane.
    """
    policy = problem.policy
    length = max(1, round(policy.slow_mean_s / problem.state.interval_s))
    means = Cut(length, len(across_nT) // length).means(across_nT)
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    turned = angles * (problem.attitude_std_rad * strength_nT) ** 2
    white = float((problem.sigma_nT[-across_nT.shape[1] :] ** 2).sum()) / length
    return bool((means**2).sum(axis=1).mean() < policy.somewhat_larger**2 * (turned + white))
