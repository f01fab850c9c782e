"""Direct evidence, before any fit: what the values themselves show of the converter and the electronics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.errors import InputError
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.effects.noise import WhiteNoise
from sim.state import Array
from validation.diagnosis.evidence.problem import Problem, sample_noise
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.lattice import find_lattice

LEAST_STEP = 0.05
"""Least significant bit in units of the noise, below which rounding is of no account."""
LOUDER = 1.1
LEAST_SPIKES = 3
FAR = 5.0
NEAR = 2
"""Samples beside a held or clipped one whose jumps are no spikes."""
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Direct:
    """An effect seen in the values themselves, and the samples (n,) that are no measurements because of it."""

    effect: Effect
    samples: Mask


def direct_evidence(problem: Problem, without: frozenset[str] = frozenset()) -> list[Direct]:
    """Rounding, full scale, repeated and single wrong values."""
    mag = problem.recording.mag_nT
    known = {effect.name: effect for effect in problem.effects}
    lattices = tuple(find_lattice(axis) for axis in mag.T)
    found = [_rounding(problem, known, lattices), _full_scale(problem, known, lattices), _held(problem, known)]
    gone = np.logical_or.reduce([_repeated(problem), *(one.samples for one in found if one is not None)])
    if found[1] is None:  # a clipped stretch has no noise of its own to measure a spike by
        found.append(_single(problem, known, lattices, _near(gone)))
    return [one for one in found if one is not None and one.effect.name not in without]


def _rounding(problem: Problem, known: dict[str, Effect], lattices: tuple[Any, ...]) -> Direct | None:
    steps = [one.step for one in lattices if one is not None and not one.floating]
    if len(steps) < len(lattices):
        return None
    step = float(np.median(steps))
    given = float(getattr(known.get("quantisation"), "step_nT", 0.0))
    if step < LEAST_STEP * problem.sigma_nT.min() or abs(step - given) < 0.01 * step:
        return None
    return _made("quantisation", _no_samples(problem), step_nT=step)


def _full_scale(problem: Problem, known: dict[str, Effect], lattices: tuple[Any, ...]) -> Direct | None:
    piles = pile_up(problem.recording.mag_nT, lattices)
    if not piles:
        return None
    level = float(np.median([abs(one.level) for one in piles]))
    given = float(getattr(known.get("saturation"), "full_scale_nT", 0.0))
    clipped: Mask = np.asarray((np.abs(problem.recording.mag_nT) >= level * (1 - 1e-9)).any(axis=1), dtype=np.bool_)
    if abs(level - given) < 1e-3 * level:
        return None
    return _made("saturation", clipped, full_scale_nT=level)


def _held(problem: Problem, known: dict[str, Effect]) -> Direct | None:
    found = repeats(problem.recording.mag_nT)
    if not found.frozen or found.hold > 1 or "dropouts" in known:
        return None
    samples = _repeated(problem)
    work_s = np.count_nonzero(~samples) * problem.state.interval_s
    # A gap hides its first sample in the one before it; lengths are exponential, so half a sample is added.
    lengths = (np.array([rows for _, rows in found.frozen]) - 0.5) * problem.state.interval_s
    return _made("dropouts", samples, rate_hz=len(lengths) / work_s, mean_duration_s=float(lengths.mean()))


def _single(problem: Problem, known: dict[str, Effect], lattices: tuple[Any, ...], beside: Mask) -> Direct | None:
    steps = np.array([0.0 if one is None else one.step for one in lattices])
    left = problem.recording.mag_nT - problem.clean_nT
    where = spikes(problem.recording.mag_nT, steps) & ~(beside | _near(_spiked_currents(problem)))[:, None]
    count = int(np.count_nonzero(where))
    if count < LEAST_SPIKES or "spikes" in known:
        return None
    size = np.abs(left - np.median(left, axis=0))[where]
    duration_s = len(left) * problem.state.interval_s
    # Small ones drown in the noise; of an exponential law what is above the least seen has the same mean.
    least = float(size.min())
    mean = max(float(size.mean()) - least, 1e-9)
    single = where.any(axis=1)
    far = (np.abs(left) > FAR * problem.sigma_nT).any(axis=1) & (single | _quiet(left, problem)) & ~beside
    rate_hz = count / duration_s * np.exp(least / mean)
    return _made("spikes", np.asarray(single | far, dtype=np.bool_), rate_hz=rate_hz, amplitude_nT=mean)


def _repeated(problem: Problem) -> Mask:
    """Rows (n,) that repeat the row before."""
    mag = problem.recording.mag_nT
    return np.asarray(np.concatenate([[False], (mag[1:] == mag[:-1]).all(axis=1)]), dtype=np.bool_)


def _spiked_currents(problem: Problem) -> Mask:
    """Samples (n,) where a motor's current jumps for a moment, as its field then does."""
    return np.asarray(spikes(problem.state.current_A).any(axis=1), dtype=np.bool_)


def _near(samples: Mask) -> Mask:
    """Samples (n,) and those beside them."""
    return np.asarray(np.convolve(samples, np.ones(2 * NEAR + 1), mode="same") > 0, dtype=np.bool_)


def _quiet(left: Array, problem: Problem) -> bool:
    """Whether the base leaves so little that a far sample must be a wrong one."""
    return problem.mode == "vector" and bool((np.median(np.abs(left), axis=0) < 1.5 * problem.sigma_nT).all())


def louder(problem: Problem, residual: Array, new: Sequence[Effect], without: frozenset[str]) -> Effect | None:
    """The white noise missing in the model, from what is left (n, q) once everything else is in.

    The rounding that the values show is taken off; a difference of a tenth counts.
    """
    known = [effect for effect in (*problem.effects, *new) if effect.name == "quantisation"]
    given = [effect for effect in problem.effects if effect.name == "white_noise"]
    if not given or problem.mode == "strength" or "white_noise" in without:
        return None
    model = np.array([effect.std_nT for effect in given])  # type: ignore[attr-defined]
    rounding = sum(effect.step_nT**2 / 12 for effect in known)  # type: ignore[attr-defined]
    expected = (model**2).sum(axis=0) + rounding
    seen = (sample_noise(residual) * problem.sigma_nT) ** 2
    if (seen <= LOUDER**2 * np.maximum(expected, 1e-12)).all():
        return None
    return WhiteNoise(vec3(np.sqrt(np.maximum(seen - expected, 0.0))))


def vec3(values: Array) -> tuple[float, float, float]:
    """Three numbers as a parameter's value."""
    return (float(values[0]), float(values[1]), float(values[2]))


def _no_samples(problem: Problem) -> Mask:
    return np.zeros(len(problem.recording), np.bool_)


def _made(name: str, samples: Mask, **values: Any) -> Direct | None:
    try:
        return Direct(BY_NAME[name](**values), samples)
    except InputError:
        return None
