"""Recordings of wide families: the course through iron, the hidden forms, noise and faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.diagnosis.wide.courses import DRAWN, Course, course
from benchmarks.diagnosis.wide.noises import COLOURS, Noise, drawn, measured
from benchmarks.diagnosis.wide.table import FAMILIES, FAULTS, FIELD, SENSOR, VEHICLE
from recordings import Recording
from scenarios.arrays import Array
from sim.scenario import ModelSpec

COLOURED_SHARE, LEAST_COLOUR, MOST_COLOUR = 0.3, 0.03, 0.3
"""Share of the runs with a hidden effect whose rest has a colour, and its sizes in units of the white noise."""
NULL_COLOUR = (0.1, 2.0)
"""The same sizes in a coloured null."""


@dataclass(frozen=True, eq=False)
class Made:
    """A recording, the model without what is hidden, the rest's colour, and whether the model's iron is unknown."""

    recording: Recording
    model: ModelSpec
    colour: str | None
    fitted_base: bool = False


def vehicle_for(hidden: Sequence[str], seed: int) -> str:
    """One that has the causes of what is hidden, drawn for it."""
    needed = frozenset().union(*(FAMILIES[name].needs for name in hidden if name in FAMILIES))
    able = [name for name in DRAWN if needed <= course(name, seed).has]
    return able[int(_rng(seed, hidden, 31).integers(len(able)))]


def hidden_in(motion: str, hidden: Sequence[str], strengths: Sequence[float], seed: int) -> Made:
    """A recording of a motion with forms (or faults) hidden at strengths, rms beside iron over the noise."""
    rng = _rng(seed, (motion, *hidden), 32)
    colour = str(rng.choice(COLOURS[:-1])) if rng.uniform() < COLOURED_SHARE else None
    noise = drawn(rng, colour, float(np.exp(rng.uniform(np.log(LEAST_COLOUR), np.log(MOST_COLOUR)))))
    return _made(course(motion, seed), hidden, strengths, noise, rng)


def hidden_along(flown: Course, name: str, strength: float) -> Made:
    """A recording of a course with one form hidden in white noise."""
    rng = _rng(0, (name,), 33)
    return _made(flown, (name,), (strength,), drawn(rng, None, 0.0), rng)


def null(motion: str, colour: str | None, seed: int, number: int) -> Made:
    """A recording of a motion in which nothing is hidden."""
    rng = _rng(seed, (motion, "null"), number)
    noise = drawn(rng, colour, float(np.exp(rng.uniform(*np.log(NULL_COLOUR)))))
    return _made(course(motion, seed), (), (), noise, rng)


def _made(
    flown: Course, hidden: Sequence[str], strengths: Sequence[float], noise: Noise, rng: np.random.Generator
) -> Made:
    iron, offset_nT = 0.05 * rng.normal(size=(3, 3)), 800 * rng.normal(size=3)
    signal = _through(flown, dict(zip(hidden, strengths, strict=True)), iron, offset_nT, noise.sigma_nT, rng)
    recording = measured(noise, flown, signal, rng)
    for name in set(hidden) & set(FAULTS):
        recording = replace(recording, mag_nT=FAULTS[name](rng, recording, noise))
    effects = {
        "soft_iron": {"matrix": iron.tolist()},
        "hard_iron": {"offset_nT": offset_nT.tolist()},
        "white_noise": {"std_nT": noise.white_nT.tolist()},
    }
    model = ModelSpec.model_validate({"effects": effects, "field": {"enu_nT": flown.field_enu_nT.tolist()}})
    return Made(recording, model, noise.colour)


def _through(
    flown: Course, hidden: dict[str, float], iron: Array, offset_nT: Array, sigma_nT: float, rng: np.random.Generator
) -> Array:
    """The signal (n, 3) behind field, vehicle and sensor, each with its hidden forms at their strengths."""
    base = flown.field_nT + flown.field_nT @ iron.T + offset_nT
    turn = {FIELD: np.eye(3) + iron, VEHICLE: np.eye(3), SENSOR: np.eye(3)}
    signal = base
    for stage in (FIELD, VEHICLE, SENSOR):
        for name, strength in hidden.items():
            if name not in FAMILIES or FAMILIES[name].stage != stage:
                continue
            form = FAMILIES[name].family(rng, flown, signal)
            size = 1.0
            for _ in range(4):
                size *= strength * sigma_nT / max(_beside_iron(form(size) @ turn[stage].T, base), 1e-9)
            signal = signal + form(size) @ turn[stage].T
    return signal


def _beside_iron(added: Array, base: Array) -> float:
    """Rms that a refitted matrix and offset leave of what is added (n, 3)."""
    design = np.column_stack([base / 5e4, np.ones(len(base))])
    left = added - design @ np.linalg.lstsq(design, added, rcond=None)[0]
    return float(np.sqrt((left**2).mean()))


def _rng(seed: int, words: Sequence[str], number: int) -> np.random.Generator:
    return np.random.default_rng([seed, number, *"/".join(words).encode()])
