"""Figures of data sheets as effects: the meaning of each quantity, defined once for all sensors.

A tolerance is drawn anew in each run, for each axis: a typical figure is the standard deviation of a normal law, a
greatest figure the bound of a uniform law.
"""

from __future__ import annotations

import math
from typing import Any

from scenarios.varied import Vary
from sim.effects.base import ZERO3
from sim.effects.dynamics import Bandwidth
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.geometry import NonOrthogonality, Scale
from sim.effects.noise import WhiteNoise
from sim.effects.nonlinearity import Hysteresis, Nonlinearity
from sim.effects.offsets import SensorOffset
from sim.effects.temperature import TemperatureOffset, TemperatureScale
from sim.sensors.base import DatasheetFigure

REFERENCE_DEGC = 25.0
"""Temperature at which data sheets give offset and sensitivity."""
PLAY_NT = 10_000.0
"""Half-width of the play of a core: small enough to be driven through by the Earth's field at every turn."""


def typical(size: float) -> Vary:
    """How a quantity differs from unit to unit whose typical size is given."""
    return Vary(normal=(0.0, size))


def within(size: float) -> Vary:
    """How a quantity differs from unit to unit whose greatest size is given."""
    return Vary(uniform=(-size, size))


def full_scale(words: str, range_nT: float, **about: Any) -> DatasheetFigure:
    """Largest field on an axis, nT; beyond, the output saturates."""
    return DatasheetFigure("range", words, Saturation, {"full_scale_nT": range_nT}, **about)


def resolution(words: str, step_nT: float, **about: Any) -> DatasheetFigure:
    """Field of a least significant bit, nT."""
    return DatasheetFigure("resolution", words, Quantisation, {"step_nT": step_nT}, **about)


def noise(words: str, *std_nT: float, **about: Any) -> DatasheetFigure:
    """Standard deviation of a sample at rest, nT, of all axes or of x, y, z; taken as white."""
    axes = list(std_nT) if len(std_nT) > 1 else 3 * list(std_nT)
    return DatasheetFigure("noise", words, WhiteNoise, {"std_nT": axes}, **about)


def noise_density(words: str, density_nT_sqrt_hz: float, **about: Any) -> DatasheetFigure:
    """One-sided amplitude density d in nT/sqrt(Hz), taken as white: ``d sqrt(f / 2)`` at the sample rate f."""

    def at(rate_hz: float) -> dict[str, list[float]]:
        return {"std_nT": 3 * [density_nT_sqrt_hz * math.sqrt(rate_hz / 2)]}

    return DatasheetFigure("noise", words, WhiteNoise, at, **about)


def offset(words: str, law: Vary, **about: Any) -> DatasheetFigure:
    """Output in no field, nT."""
    return DatasheetFigure("offset", words, SensorOffset, {"offset_nT": list(ZERO3)}, {"offset_nT": law}, **about)


def offset_drift(words: str, law: Vary, **about: Any) -> DatasheetFigure:
    """Change of the offset with temperature, nT/K."""
    values = {"slope_nT_K": list(ZERO3), "reference_degC": REFERENCE_DEGC}
    return DatasheetFigure("offset drift", words, TemperatureOffset, values, {"slope_nT_K": law}, **about)


def sensitivity(words: str, law: Vary, **about: Any) -> DatasheetFigure:
    """Relative error of the sensitivity."""
    return DatasheetFigure("sensitivity", words, Scale, {"error": list(ZERO3)}, {"error": law}, **about)


def sensitivity_drift(words: str, law: Vary, **about: Any) -> DatasheetFigure:
    """Change of the sensitivity with temperature, 1/K."""
    values = {"slope_1_K": list(ZERO3), "reference_degC": REFERENCE_DEGC}
    return DatasheetFigure("sensitivity drift", words, TemperatureScale, values, {"slope_1_K": law}, **about)


def sensitivity_slope(words: str, slope_1_K: float, **about: Any) -> DatasheetFigure:
    """Change of the sensitivity with temperature, common to all units, 1/K."""
    values = {"slope_1_K": 3 * [slope_1_K], "reference_degC": REFERENCE_DEGC}
    return DatasheetFigure("sensitivity drift", words, TemperatureScale, values, **about)


def orthogonality(words: str, law: Vary, **about: Any) -> DatasheetFigure:
    """Angles between the axes minus 90 degrees, degrees."""
    return DatasheetFigure(
        "orthogonality", words, NonOrthogonality, {"angles_deg": list(ZERO3)}, {"angles_deg": law}, **about
    )


def linearity(words: str, part: float, span_nT: float, **about: Any) -> DatasheetFigure:
    """Largest departure from the best straight line over +-span, relative to the span.

    Modelled as a cubic: ``c3 x^3`` departs from the best line over -1 to 1 by ``c3 / 4`` (Chebyshev).
    """
    values = {"third_order": list(ZERO3), "reference_nT": span_nT}
    return DatasheetFigure("linearity", words, Nonlinearity, values, {"third_order": within(4 * part)}, **about)


def hysteresis(words: str, width_nT: float, **about: Any) -> DatasheetFigure:
    """Distance between the ways up and down, nT: a stop operator of half-width r and gain g leaves ``2 g r``."""
    values = {"gain": 3 * [width_nT / (2 * PLAY_NT)], "threshold_nT": PLAY_NT}
    return DatasheetFigure("width of hysteresis", words, Hysteresis, values, **about)


def bandwidth(words: str, cutoff_hz: float, **about: Any) -> DatasheetFigure:
    """Frequency in Hz of half power."""
    return DatasheetFigure("frequency response", words, Bandwidth, {"cutoff_hz": cutoff_hz}, **about)
