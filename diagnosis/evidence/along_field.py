"""Part of a residual along the field, where attitude errors have no part, and slow errors that the model states."""

from __future__ import annotations

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

    V is the largest variance of means over 1, 2, 4, ... of these, constant for white noise, of which at least `least`
    remain; None: only V of the means themselves.
    """
    poorer, richer = (residual_along_field(baseline) for baseline in (before, after))
    longest = len(richer) // (least or len(richer))
    cuts = (Cut(2**j, len(richer) >> j) for j in range(longest.bit_length()))
    V = max((cut.length * float((cut.means(richer) ** 2).mean()) for cut in cuts), default=1.0)
    return float((poorer**2).sum() - (richer**2).sum()) / 2 / max(1.0, V)


def share_along_field(before: Baseline, after: Baseline) -> float:
    """Share of the excess of means along the field over white noise that was explained; 0 without an excess."""
    excess, left = ((residual_along_field(one) ** 2 - 1).sum() for one in (before, after))
    return float(1 - left / excess) if excess > 0 else 0.0


def residual_along_field(baseline: Baseline) -> Array:
    """Means (m,) of a baseline's residual along the field over `slow_mean_s`; white noise has variance 1."""
    problem, cut = baseline.problem, _slow_means(baseline.problem)
    along, base = along_field(problem, baseline.residual())
    return np.asarray(np.sqrt(cut.length) * _without(cut.means(base), cut.means(along)))


def parts_of_residual(problem: LinearProblem, residual: Array) -> tuple[Array, Array]:
    """Parts in nT of a residual (n, q) along the field (n,) and across it (n, 1 or 3), ahead of the iron."""
    residual_nT = residual * problem.sigma_nT
    if problem.output_axes is not None:
        return residual_nT[:, 0], residual_nT[:, 1:]
    field_nT = problem.ahead_of_iron(residual_nT)
    along_nT = np.einsum("ni,ni->n", field_nT, problem.direction)
    return along_nT, field_nT - along_nT[:, None] * problem.direction


def along_field(problem: LinearProblem, residual: Array) -> tuple[Array, Array]:
    """Residual (n, q) along the field over its noise (n,), and columns (n, 9) that a matrix fitted to a turn leaves."""
    if problem.output_axes is not None:
        noise_nT = np.full(len(residual), problem.sigma_nT[0])
    else:
        noise_nT = np.linalg.norm(problem.field_projection * problem.sigma_nT, axis=1)
    columns = strength_columns(problem.direction) * (problem.usable / noise_nT)[:, None]
    return parts_of_residual(problem, residual)[0] / noise_nT, columns


def is_attitude_error(problem: LinearProblem, residual: Array, mean_s: float | None = None) -> bool:
    """Whether a residual (n, q) has next to no power along the field, in means over `mean_s`, else `slow_mean_s`."""
    cut = _slow_means(problem, mean_s)
    along, across = (float((cut.means(part) ** 2).sum()) for part in parts_of_residual(problem, residual))
    return problem.compares_across and along < problem.policy.least_along_field * (along + across)


def within_stated_errors(problem: LinearProblem, residual: Array) -> bool:
    """Whether a residual (n, q), in units of the noise, is no larger than the slow errors stated by the model.

    The part along the field, which keeps its strength in any attitude, must be white noise plus the stated wander, and
    the part across, in means, no larger than the stated attitude error; every axis as the former if none is stated.
    """
    if problem.attitude_std_rad == 0 or not problem.compares_across:
        return states_slow_noise(problem) and _is_white_and_wander(problem, residual)
    along, base = along_field(problem, residual)
    if not _is_white_and_wander(problem, _without(base, along)[:, None]):
        return False
    across_nT, cut = parts_of_residual(problem, residual)[1], _slow_means(problem)
    angles = min(across_nT.shape[1], 2)  # two angles turn the field in the plane that is seen
    turned = angles * (problem.attitude_std_rad * float(np.linalg.norm(problem.state.field_enu_nT))) ** 2
    white = float((problem.sigma_nT[-across_nT.shape[1] :] ** 2).sum()) / cut.length
    seen = (cut.means(across_nT) ** 2).sum(axis=1).mean()
    return bool(seen < problem.policy.somewhat_larger**2 * (turned + white))


def states_slow_noise(problem: LinearProblem) -> bool:
    """Whether the model has an effect of slow noise."""
    return any(effect.traits.spectrum is not None for effect in problem.effects)


def _is_white_and_wander(problem: LinearProblem, residual: Array) -> bool:
    """Whether no band of a residual's spectrum exceeds white noise plus the slow noise that the model states."""
    policy, interval_s = problem.policy, problem.state.interval_s
    bands = Bands.of(residual, interval_s, policy.first_line, policy.bands)
    expected = np.full(len(bands.f), max(2 * interval_s, float(bands.power[-1])))
    noise_nT = problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]
    for effect in problem.effects:
        shape, level = effect.traits.spectrum, effect.with_role("level")
        if shape is not None and level is not None:
            listed = {name: getattr(effect, name) for name in effect.search}
            size = float(((np.array(getattr(effect, level)) / noise_nT) ** 2).mean())
            expected += size * shape(bands.f, interval_s, **listed)
    margin = policy.somewhat_larger if states_slow_noise(problem) else 1.0
    return bands.chance(bands.power / expected / margin) > policy.test_alarm


def _slow_means(problem: LinearProblem, mean_s: float | None = None) -> Cut:
    """Cut of the samples into two means at least, over `mean_s` or the policy's `slow_mean_s`."""
    n = len(problem.target)
    length = max(1, min(round((mean_s or problem.policy.slow_mean_s) / problem.state.interval_s), n // 2))
    return Cut(length, n // length)


def _without(base: Array, course: Array) -> Array:
    """A course (n,) with base columns (n, p) projected out."""
    return np.asarray(course - base @ np.linalg.lstsq(base, course, rcond=1e-9)[0])
