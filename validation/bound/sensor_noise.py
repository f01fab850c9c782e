"""The sensor's noise as its effects state it, rms over the axes."""

from __future__ import annotations

import numpy as np

from sim.effects.base import Effect
from sim.effects.noise import FlickerNoise, WhiteNoise
from sim.effects.offsets import OffsetRandomWalk
from sim.effects.parameters import Vec3
from validation.bound.colour import Colour


def stated_noise_nT(effects: tuple[Effect, ...]) -> float | None:
    """Of white noise; None where they state none."""
    return _rms([one.std_nT for one in effects if isinstance(one, WhiteNoise)])


def stated_colour(effects: tuple[Effect, ...]) -> Colour | None:
    """Flicker noise and random walk; None where they state neither."""
    flicker = _rms([one.density_nT_sqrt_hz for one in effects if isinstance(one, FlickerNoise)])
    walk = _rms([one.std_nT_sqrt_s for one in effects if isinstance(one, OffsetRandomWalk)])
    return Colour(flicker or 0.0, walk or 0.0) if flicker or walk else None


def _rms(stated: list[Vec3]) -> float | None:
    """Of several that add up, rms over the axes; None of none."""
    return float(np.sqrt(np.mean(np.square(stated)) * len(stated))) if stated else None
