"""Part of a residual along the field, where attitude errors have no part, and slow errors that the model states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import search_price
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_columns
from scenarios.arrays import Array
from validation.signals.bands import Bands


def explains_along_field(before: Baseline, after: Baseline, tried: int = 1) -> bool:
    """Whether newly accepted effects explain the residual along the field too, where attitude errors have no part.

    Nats less the chance gain of k columns, ``k / 2``, and less the price of a search among `tried` settings; slow noise
    raises the chance gain by the largest variance of means as long as k columns can follow.
    """
    policy, k = before.problem.policy, after.sums.width - before.sums.width
    by_chance = k / 2 + search_price(tried, k, policy)
    return bool(gain_along_field(before, after, k) - by_chance > policy.apart)


def gain_along_field(before: Baseline, after: Baseline, least: int | None = None) -> float:
    """Nats ``(b - a) / 2 / V`` along the field, b and a the squares of means over `slow_mean_s` before and after.

    V is the largest variance of longer means, of which at least `least` remain; None: only V of the means themselves.
    """
    poorer, richer = (residual_along_field(baseline) for baseline in (before, after))
    loudest = max(_variances_of_means(richer, least or len(richer)), default=1.0)
    return float((poorer**2).sum() - (richer**2).sum()) / 2 / max(1.0, loudest)


def share_along_field(before: Baseline, after: Baseline) -> float:
    """Share of the excess of means along the field over white noise that was explained; 0 without an excess."""
    poorer, richer = (residual_along_field(baseline) for baseline in (before, after))
    excess = float((poorer**2).sum()) - len(poorer)
    return 1 - (float((richer**2).sum()) - len(richer)) / excess if excess > 0 else 0.0


def _variances_of_means(course: Array, least: int) -> Iterator[float]:
    """Variances of means over 1, 2, 4, ... values of a course, each times the length: constant for white noise."""
    length = 1
    while len(course) >= least * length:
        sums = course[: len(course) // length * length].reshape(-1, length).sum(axis=1)
        yield float((sums**2).mean()) / length
        length *= 2


def residual_along_field(baseline: Baseline) -> Array:
    """Means (m,) of a baseline's residual along the field over `slow_mean_s`; white noise has variance 1.

    The columns of a strength fit are projected out: a matrix that was fitted to a turn of the field leaves residuals
    along them.
    """
    problem = baseline.problem
    along, base = along_field(problem, baseline.residual())
    length = max(1, min(round(problem.policy.slow_mean_s / problem.state.interval_s), len(along) // 2))
    cut = Cut(length, len(along) // length)
    return np.asarray(np.sqrt(length) * _without(cut.means(base), cut.means(along)))


def along_field(problem: LinearProblem, residual: Array) -> tuple[Array, Array]:
    """Residual (n, q) along the field over its noise (n,), and the columns (n, 9) of a fit of the strength there."""
    if problem.output_axes is not None:
        along, unit = residual[:, 0], np.full(len(residual), problem.sigma_nT[0])
    else:
        back = problem.field_projection * problem.sigma_nT
        unit = np.linalg.norm(back, axis=1)
        along = (back * residual).sum(axis=1) / unit
    return along, strength_columns(problem.direction) * (problem.usable / unit)[:, None]


def _without(base: Array, course: Array) -> Array:
    """A course (n,) with base columns (n, p) projected out."""
    return np.asarray(course - base @ np.linalg.lstsq(base, course, rcond=1e-9)[0])


def is_attitude_error(problem: LinearProblem, residual: Array, mean_s: float | None = None) -> bool:
    """Whether means of a residual (n, q) have no part along the field, see `power_share_along_field`."""
    return (
        problem.compares_across
        and power_share_along_field(problem, residual, mean_s) < problem.policy.least_along_field
    )


def power_share_along_field(problem: LinearProblem, residual: Array, mean_s: float | None = None) -> float:
    """Share of a residual's power along the field, in means over `mean_s`, by default the policy's `slow_mean_s`."""
    length = max(1, round((mean_s or problem.policy.slow_mean_s) / problem.state.interval_s))
    cut = Cut(length, len(residual) // length)
    if problem.level is not None:
        power = (cut.means(residual * problem.sigma_nT) ** 2).sum(axis=0)
        return float(power[0] / max(power.sum(), 1e-300))
    turned = problem.state.field_nT @ problem.turn.T
    direction = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    nT, u = cut.means(residual * problem.sigma_nT), cut.means(direction)
    return float(((nT * u).sum(axis=1) ** 2).sum() / max((nT**2).sum(), 1e-300))


def within_stated_errors(problem: LinearProblem, residual: Array) -> bool:
    """Whether a residual (n, q), in units of the noise, is no larger than the slow errors stated by the model.

    An attitude error turns the field and keeps the field's strength. The part along the field, with the nine columns of
    a strength fit projected out, must be white noise plus the stated wander; the part across the field must be no
    larger than the stated attitude error. Without a stated attitude error the first condition holds for every axis.
    """
    if problem.attitude_std_rad == 0 or not problem.compares_across:
        return states_slow_noise(problem) and _as_white_and_wander(problem, residual)
    if problem.level is not None:
        across_nT, angles = residual[:, 1:] * problem.sigma_nT[1:], 1
    else:
        nT, angles = (residual * problem.sigma_nT) @ np.linalg.inv(problem.turn).T, 2
        across_nT = nT - (nT * problem.direction).sum(axis=1)[:, None] * problem.direction
    along, base = along_field(problem, residual)
    return _as_white_and_wander(problem, _without(base, along)[:, None]) and _small_across(problem, across_nT, angles)


def states_slow_noise(problem: LinearProblem) -> bool:
    """Whether the model has an effect of slow noise."""
    return any(effect.traits.spectrum is not None for effect in problem.effects)


def _wander(problem: LinearProblem, f: Array) -> Array:
    """Power density (m,) of the model's slow noise at frequencies f (m,), averaged over axes, in units of the noise."""
    total = np.zeros(len(f))
    noise_nT = problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]
    for effect in problem.effects:
        shape, level = effect.traits.spectrum, effect.with_role("level")
        if shape is not None and level is not None:
            std = np.array(getattr(effect, level))
            listed = {name: getattr(effect, name) for name in effect.search}
            total += float(((std / noise_nT) ** 2).mean()) * shape(f, problem.state.interval_s, **listed)
    return total


def _as_white_and_wander(problem: LinearProblem, values: Array) -> bool:
    """Whether no band of the spectrum exceeds white noise plus the stated wander."""
    policy, interval_s = problem.policy, problem.state.interval_s
    bands = Bands.of(values, interval_s, policy.first_line, policy.bands)
    expected = max(2 * interval_s, float(bands.power[-1])) + _wander(problem, bands.f)
    margin = policy.somewhat_larger if states_slow_noise(problem) else 1.0
    return bool((bands.odds(bands.power / expected / margin) > policy.test_alarm / len(bands.f)).all())


def _small_across(problem: LinearProblem, across_nT: Array, angles: int) -> bool:
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
