"""Noise of a sensor as stated by the effects, rms over the axes."""

from __future__ import annotations

import numpy as np

from sim.effects.base import Effect
from sim.effects.noise import FlickerNoise, WhiteNoise
from sim.effects.offsets import OffsetRandomWalk
from sim.effects.parameters import Vec3
from validation.bound.colour import Colour


def stated_noise_nT(effects: tuple[Effect, ...]) -> float | None:
    """Return the stated white noise, None without or of zero."""
    return _rms([one.std_nT for one in effects if isinstance(one, WhiteNoise)]) or None


def stated_colour(effects: tuple[Effect, ...]) -> Colour | None:
    """Return the stated flicker noise and random walk, None without both."""
    flicker = _rms([one.density_nT_sqrt_hz for one in effects if isinstance(one, FlickerNoise)])
    walk = _rms([one.std_nT_sqrt_s for one in effects if isinstance(one, OffsetRandomWalk)])
    return Colour(flicker or 0.0, walk or 0.0) if flicker or walk else None


def _rms(stated: list[Vec3]) -> float | None:
    """Return the rms over the axes of a sum of independent noises, None of no noise."""
    return float(np.sqrt(np.mean(np.square(stated)) * len(stated))) if stated else None
