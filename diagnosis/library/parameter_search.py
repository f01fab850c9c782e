"""Searches for parameters without a list of values: step times, tones, places, origins; refinement of listed values."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from diagnosis.library.candidates import Candidate
from diagnosis.library.dipole_position import find_places
from diagnosis.problem.blocks import Cut, extend_sums, fit, sums
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.resampling import SPARSEST

PIECE = 2_000
"""Samples processed at once: limits the memory of sums over products of columns."""
OWN_NOISE = 10.0
"""Ratio to the noise of the measured direction below which a step along the direction is noise fitted to noise."""
LEAST_SHARE = 1e-10
"""Least share of a column's mean square that the own noise counts for: with less, rounding decides where iron explains
a step at every time, as at constant attitude."""


def search_parameters(problem: LinearProblem, residual: Array, settings: list[Candidate]) -> list[Candidate]:
    """The settings of a candidate after the search of its class, if any, for the best fit to the residual (n, q).

    The first setting is searched; the remaining settings adopt the result.
    """
    role = settings[0].effect.search_role()
    if role is None:
        return settings
    found = SEARCHES[role](problem, residual, settings[0], str(settings[0].effect.with_role(role)))
    return [one.at(dict(best.nonlinear) | dict(one.nonlinear), best.tried) for best in found for one in settings]


def find_moments(problem: LinearProblem, residual: Array, candidate: Candidate, name: str) -> list[Candidate]:
    """The candidate at the best step time for a residual (n, q) of the fitted base, every sample compared."""
    best = int(np.argmax(step_gains(problem, residual, candidate)))
    return [candidate.at({name: float(problem.state.time_s[best])}, len(residual))]


def step_gains(problem: LinearProblem, residual: Array, candidate: Candidate) -> Array:
    """Squares (n,) that a step at each time t explains beside the base, 0 at either end; all sums from t on.

    Along each axis, without columns: ``|sum y|^2 / (n_t - b_t^T (B^T B)^-1 b_t)``, n_t and b_t the sums of 1 and B. By
    the strength, with columns E (n, q, k) of the candidate: ``z' (E'E - E'B (B'B)^-1 B'E)^-1 z``, ``z = E'y``: on long
    legs iron absorbs much of a step, and more of a step at the wrong time.
    """
    B = problem.base.reshape(-1, problem.base.shape[-1])
    inverse, y = np.asarray(np.linalg.pinv(B.T @ B, rcond=1e-13, hermitian=True)), residual.reshape(len(B), -1)
    free, margin = (y - B @ (inverse @ (B.T @ y))).reshape(residual.shape), problem.policy.step_margin
    if problem.mode == "vector":
        beyond_B, beyond_1, beyond_y = (_sums_to_end(values) for values in (problem.base, problem.usable, free))
        size = beyond_1 - np.einsum("np,pr,nr->n", beyond_B, inverse, beyond_B)
        shown = size >= margin * size.max()
        return np.asarray(np.where(shown, (beyond_y**2).sum(axis=1) / np.maximum(size, 1e-9), 0.0))
    gain = _gains_of_columns(problem, inverse, free, candidate.columns(problem))
    edge = max(2, int(len(residual) * margin))
    gain[:edge] = gain[-edge:] = 0.0
    return gain


def _gains_of_columns(problem: LinearProblem, inverse: Array, residual: Array, E: Array) -> Array:
    """Squares (n,) that columns E (n, q, k) beginning at each time explain, inverse (p, p): of ``B'B``."""
    n, q, k = E.shape
    parts = (problem.base.reshape(n, q, -1), residual[:, :, None], E)
    gain, own, beyond = np.zeros(n), _own_noise(problem, E), np.zeros((1, sum(part.shape[2] for part in parts), k))
    for end in range(n, 0, -PIECE):
        here = slice(max(end - PIECE, 0), end)
        every = np.concatenate([part[here] for part in parts], axis=2)
        beyond = beyond[0] + _sums_to_end(every.transpose(0, 2, 1) @ E[here])
        BE, z, EE = np.split(beyond, [-k - 1, -k], axis=1)
        free = EE - np.einsum("npi,pr,nrj->nij", BE, inverse, BE, optimize=True) + own[here, None, None] * np.eye(k)
        # a pseudo-inverse: at a constant attitude iron absorbs all of a step
        gain[here] = np.einsum("nqk,nkj,nqj->n", z, np.linalg.pinv(free, hermitian=True), z)
    return gain


def _own_noise(problem: LinearProblem, E: Array) -> Array:
    """Squares (n,) of noise in columns E (n, q, k), in the shorter part: the field's direction is a measurement too."""
    noise = float(problem.sigma_nT[0] / np.linalg.norm(problem.state.field_nT[0]))
    share = max((OWN_NOISE * noise) ** 2, LEAST_SHARE)
    after = _sums_to_end(problem.usable)
    shorter = np.minimum(after, after[0] - after) + 1.0
    return np.asarray(share * float((E**2).sum(axis=1).mean()) * shorter)


def _sums_to_end(values: Array) -> Array:
    """Sums (n, ...) of values (n, ...) from each sample to the end."""
    return np.cumsum(values[::-1], axis=0)[::-1]


def find_tones(problem: LinearProblem, residual: Array, candidate: Candidate, name: str) -> list[Candidate]:
    """The candidate at the strongest line in the spectrum of residual (n, q) times current; either phase is included.

    The product also contains the direction of each axis: along a rotating field the amplitude of a steady tone is
    modulated.
    """
    time_s, interval_s, policy = problem.state.time_s, problem.state.interval_s, problem.policy
    motor = candidate.effect.with_role("motor")
    drive_A = problem.state.current_of(dict(candidate.nonlinear).get(motor, 0)) if motor else np.ones(len(residual))
    unit_nT = drive_A[:, None, None] * np.eye(3)
    weighted = np.einsum("nq,nqk->nk", residual, problem.whitened(unit_nT, candidate.effect))
    even = _in_slots(weighted, time_s, interval_s)
    f = np.fft.rfftfreq(len(even), interval_s)
    power = (np.abs(np.fft.rfft(even, axis=0)) ** 2).sum(axis=1)
    power[f < max(policy.slowest_tone_hz, policy.least_tone_cycles / (len(even) * interval_s))] = 0.0
    tone_hz = _between_lines(weighted, time_s, float(f[int(np.argmax(power))]), f[1])
    return [candidate.at({name: tone_hz}, len(f))]


def _in_slots(values: Array, time_s: Array, interval_s: float) -> Array:
    """Values (m, k) in even slots, zero in gaps; unchanged for a recording with more gaps than samples."""
    slot = np.rint((time_s - time_s[0]) / interval_s).astype(np.intp)
    if slot[-1] >= SPARSEST * len(time_s):
        return values
    even = np.zeros((int(slot[-1]) + 1, values.shape[1]))
    np.add.at(even, slot, values)
    return even


def _between_lines(weighted: Array, time_s: Array, centre: float, line_hz: float) -> float:
    """Frequency of the largest power within a spectral line, to a hundredth of a line."""
    step = line_hz / 2
    for _ in range(4):
        wave, next_wave = (np.exp(-2j * np.pi * hz * time_s) for hz in (centre - step, step / 4))
        power = []
        for _ in range(9):
            power.append(float((np.abs(wave @ weighted) ** 2).sum()))
            wave *= next_wave
        centre, step = centre + step * (int(np.argmax(power)) / 4 - 1), step / 4
    return max(centre, 1e-6)


def find_origins(problem: LinearProblem, residual: Array, candidate: Candidate, name: str) -> list[Candidate]:
    """The given origin of a field linear in position, and the least-squares origin for a residual (n, q).

    ``R_wb^T (G (p - m) + c)`` is linear in G and in the constant c, m the mean position; the field vanishes at ``m +
    d`` with ``G d = -c``, d the shortest across the field: along the field c is a scale, absorbed by the base. Search
    price: at least as many positions as the dipole search compares.
    """
    middle, field_enu_nT = problem.state.pos_enu_m.mean(axis=0), problem.state.field_enu_nT
    G, c = _gradient_and_constant(problem, residual, candidate.at({name: tuple(map(float, middle))}))
    across = np.eye(3) - np.outer(field_enu_nT, field_enu_nT) / (field_enu_nT @ field_enu_nT)
    place = middle - np.linalg.pinv(across @ G, rcond=1e-9) @ (across @ c)
    low, high = next((p.low, p.high) for p in candidate.effect.parameters() if p.name == name)
    beside = candidate.at({name: tuple(map(float, place))}, problem.policy.place_cells**3)
    return [candidate, beside] if ((low <= place) & (place <= high)).all() else [candidate]


def _gradient_and_constant(problem: LinearProblem, residual: Array, about: Candidate) -> tuple[Array, Array]:
    """Least-squares matrix G (3, 3) about the candidate's origin, and constant c (3,), beside the base."""
    columns = np.concatenate([about.columns(problem), problem.earth_axes()], axis=2)
    cut = Cut.of(len(residual), problem.state.interval_s, problem.policy)
    bare = sums(cut, problem.base, residual, problem.usable)
    found = fit(extend_sums(bare, cut, problem.base, [residual[:, :, None]], columns), bare.all_folds).c
    G = sum(value * unit for value, (_, unit) in zip(found[:-3], about.effect.linear_units(), strict=True))
    return np.asarray(G), found[-3:]


SEARCHES = {"moment": find_moments, "frequency": find_tones, "place": find_places, "origin": find_origins}
"""Search by the role of the parameter, of which each gets the name."""


def refine_between_neighbours(candidate: Candidate, misfit: Callable[[Candidate], float]) -> Candidate | None:
    """The candidate with its single listed number at the least misfit between the neighbours in the list.

    An earlier search may have moved the number between two listed values.
    """
    if len(candidate.effect.search) != 1 or candidate.effect.search_role():
        return None
    ((name, listed),) = candidate.effect.search.items()
    best = between_neighbours(listed, dict(candidate.nonlinear)[name], lambda x: misfit(candidate.at({name: x})))
    return candidate.at({name: best}, max(candidate.tried, len(listed)))


def between_neighbours(
    listed: Sequence[float], value: float, misfit: Callable[[float], float], within: float = 0.01
) -> float:
    """The number of least misfit between the neighbours of a value in a list, to a share `within` of the number."""
    low = max((one for one in listed if one < value), default=value)
    high = min((one for one in listed if one > value), default=value)
    if low == high:
        return value
    bounds = np.log(max(low, high * 1e-3)), np.log(high)
    options = {"xatol": within, "maxiter": 12}
    found = minimize_scalar(lambda x: misfit(float(np.exp(x))), bounds=bounds, method="bounded", options=options)
    return float(np.exp(found.x))
