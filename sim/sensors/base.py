"""A commercial magnetometer: the figures of the data sheet, and the meaning of each in the chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from scenarios.varied import Vary
from sim.effects.base import Effect

Values = Mapping[str, Any]
"""Parameters of an effect by name."""


@dataclass(frozen=True)
class DatasheetFigure:
    """A figure of a data sheet: the wording of the sheet, and the corresponding effect.

    values : parameters of the effect, or a function of the sample rate in Hz that returns them.
    spread : distribution of parameters over the units of a type; empty for a figure without tolerance.
    compared : True if the figure was compared with the document, False if only with a quotation.
    """

    quantity: str
    words: str
    effect: type[Effect]
    values: Values | Callable[[float], Values]
    spread: Mapping[str, Vary] = field(default_factory=dict)
    compared: bool = True

    def at(self, rate_hz: float) -> Values:
        """The effect's parameters at a sample rate, for a unit in the middle of the tolerances."""
        return self.values(rate_hz) if callable(self.values) else self.values


@dataclass(frozen=True)
class Sensor:
    """A magnetometer with the figures of the data sheet.

    document : title and revision of the sheet. left_out : quantities missing from the sheet or without an effect.
    fastest_hz : the greatest sample rate, None where the sheet gives none below the simulator's. scalar : True for a
    magnetometer of the field's strength.
    """

    name: str
    summary: str
    document: str
    figures: tuple[DatasheetFigure, ...]
    left_out: str
    fastest_hz: float | None = None
    scalar: bool = False

    def tables(self, rate_hz: float) -> dict[str, dict[str, Any]]:
        """The effects' tables for a scenario, at a sample rate in Hz, for a unit in the middle of the tolerances."""
        found: dict[str, dict[str, Any]] = {}
        for figure in self.figures:
            found.setdefault(figure.effect.name, {}).update(figure.at(rate_hz))
        return found

    def spread(self) -> dict[tuple[str, str], Vary]:
        """(effect, parameter) -> distribution over the units of a type."""
        return {(one.effect.name, key): how for one in self.figures for key, how in one.spread.items()}
