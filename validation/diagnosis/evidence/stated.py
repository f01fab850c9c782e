"""What the model itself says of slow errors: its own wander of the sensor, and the errors of its navigation."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.stats import gamma

from sim.effects.drift import OffsetRandomWalk
from sim.effects.noise import FlickerNoise
from sim.state import Array
from validation.diagnosis.evidence.noise import SHAPES, spectrum_bands
from validation.diagnosis.evidence.problem import Problem

POOR, LARGER = 1e-3, 1.5
SMOOTH_S = 5.0


def as_stated(problem: Problem, residual: Array) -> bool:
    """Whether a residual (n, q), in units of the noise, is no more than the slow errors that the model states.

    An attitude error turns the field, which leaves its strength alone: the part along the undisturbed field, with the
    nine columns of a strength fit taken off, must be white beside the model's own flicker noise and random walk, and
    the part across must be as small as the stated error makes it. Without a stated attitude error every axis must be
    so.
    """
    wanders = _wanders(problem)
    if problem.attitude_std_rad == 0 or problem.mode != "vector":
        return bool(wanders) and _as_white_and(problem, residual, wanders)
    back = np.linalg.inv(problem.turn)
    u = problem.state.field_nT / np.linalg.norm(problem.state.field_nT, axis=1, keepdims=True)
    nT = (residual * problem.sigma_nT) @ back.T
    along = (nT * u).sum(axis=1)
    across = nT - along[:, None] * u
    unit_nT = np.linalg.norm((u @ back) * problem.sigma_nT, axis=1)
    scaled = _without_strength(along / unit_nT, u, problem.usable)
    return _as_white_and(problem, scaled[:, None], wanders) and _small_across(problem, across)


def _wanders(problem: Problem) -> dict[str, float]:
    """Size of each slow noise of the model, squared, mean over axes, in units of the noise."""
    out: dict[str, float] = {}
    for effect in problem.effects:
        if isinstance(effect, FlickerNoise | OffsetRandomWalk):
            std = np.array(effect.density_nT_sqrt_hz if isinstance(effect, FlickerNoise) else effect.std_nT_sqrt_s)
            out[effect.name] = out.get(effect.name, 0.0) + float(((std / problem.sigma_nT) ** 2).mean())
    return out


def _as_white_and(problem: Problem, values: Array, wanders: dict[str, float]) -> bool:
    """Whether no band of a spectrum has more power than white noise and the stated wanders give it."""
    interval_s = problem.state.interval_s
    f, power, dof = spectrum_bands(values, interval_s)
    level = max(2 * interval_s, float(power[-1]))
    expected = level + sum(size * SHAPES[name](f) for name, size in wanders.items())
    limit = POOR / len(f)
    return bool((gamma.sf(power / expected / (LARGER if wanders else 1.0), dof, scale=1 / dof) > limit).all())


def _without_strength(along: Array, u: Array, usable: Array) -> Array:
    pairs = itertools.combinations_with_replacement(range(3), 2)
    design = np.column_stack([*(u[:, i] * u[:, j] for i, j in pairs), u]) * usable[:, None]
    return np.asarray(along - design @ np.linalg.lstsq(design, along, rcond=1e-9)[0])


def _small_across(problem: Problem, across_nT: Array) -> bool:
    """Whether means of the part across the field are as small as the stated attitude error and the noise make them."""
    length = max(1, round(SMOOTH_S / problem.state.interval_s))
    m = len(across_nT) // length
    means = across_nT[: m * length].reshape(m, length, 3).mean(axis=1)
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    turned = 2 * (problem.attitude_std_rad * strength_nT) ** 2
    white = float((problem.sigma_nT**2).sum()) / length
    return bool((means**2).sum(axis=1).mean() < LARGER**2 * (turned + white))
