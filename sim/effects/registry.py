"""The table of all effects, in physical order.

To add an effect: a class in a file of this package, and a line in EFFECTS. Injection, labels, checks, `list effects`,
the editor's schema, the documentation, the diagnosis and the contract tests follow.
"""

from __future__ import annotations

import difflib
from typing import Any

from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.channels import ChannelEffect
from sim.effects.currents import CurrentRipple, EddyCurrent, MotorCurrent, SteadyTone
from sim.effects.dynamics import Bandwidth, Latency
from sim.effects.earth import AttitudeMisalignment, DiurnalDrift, FieldGradient, RegionalField
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts, Spikes
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.iron import HardIron, HardIronDrift, SoftIron
from sim.effects.noise import FlickerNoise, GaussMarkovNoise, WhiteNoise
from sim.effects.nonlinearity import Hysteresis, Nonlinearity
from sim.effects.offsets import OffsetJump, OffsetRandomWalk, SensorOffset
from sim.effects.sources import LocalDipole
from sim.effects.temperature import TemperatureOffset, TemperatureScale
from sim.effects.traits import Sign

EFFECTS: tuple[type[Effect], ...] = (
    # field
    RegionalField,
    DiurnalDrift,
    FieldGradient,
    LocalDipole,
    AttitudeMisalignment,
    # vehicle
    SoftIron,
    HardIron,
    HardIronDrift,
    EddyCurrent,
    MotorCurrent,
    CurrentRipple,
    SteadyTone,
    # sensor
    Misalignment,
    NonOrthogonality,
    Scale,
    Nonlinearity,
    TemperatureScale,
    TemperatureOffset,
    Hysteresis,
    Bandwidth,
    Latency,
    ChannelEffect,
    SensorOffset,
    OffsetJump,
    OffsetRandomWalk,
    FlickerNoise,
    GaussMarkovNoise,
    WhiteNoise,
    # electronics
    Saturation,
    Quantisation,
    Spikes,
    Dropouts,
)
"""Every effect, in the default order of the chain."""

BY_NAME: dict[str, type[Effect]] = {cls.name: cls for cls in EFFECTS}
BY_SIGN: dict[Sign, type[Effect]] = {cls.traits.sign: cls for cls in EFFECTS if cls.traits.sign}
"""Every effect that the measured values themselves show."""


def find(name: str, where: str) -> type[Effect]:
    """The class of an effect; InputError with the nearest names if the name is unknown."""
    if name in BY_NAME:
        return BY_NAME[name]
    raise InputError(f"no effect {name!r}", where=where, do=nearest(name))


def of_sign(sign: Sign, *values: Any) -> Effect:
    """The effect that shows in the values by a sign, with its parameters in their order."""
    return BY_SIGN[sign](*values)


def nearest(name: str) -> str:
    """The known names nearest to an unknown name, as advice."""
    near = difflib.get_close_matches(name, BY_NAME, n=3) or list(BY_NAME)
    return "did you mean " + ", ".join(near) + "?"


def summary(name: str) -> str:
    """The first sentence of an effect's documentation."""
    return " ".join((find(name, "effects").__doc__ or "").split("\n\n")[0].split())


def describe(name: str) -> str:
    """An effect's documentation, and the parameters with unit, range, default and meaning."""
    cls = find(name, "effects")
    lines = [f"{name} ({cls.stage}): {summary(name)}"]
    lines += ["    " + line.strip() for line in (cls.__doc__ or "").split("\n")[1:] if line.strip()]
    for p in cls.parameters():
        span = p.expected if p.worded else f"{p.low:g} to {p.high:g} {p.unit}".rstrip()
        values = ", ".join(p.options) or span
        lines.append(f"  {p.name} = {p.default}  ({values}): {p.doc}")
    return "\n".join(lines)
