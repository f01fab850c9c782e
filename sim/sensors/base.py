"""A magnetometer that can be bought: the figures of its data sheet, and what each means in the chain."""

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
    """One figure of a data sheet: its words there, and the effect that stands for it.

    values : parameters of the effect, or a function of the sample rate in Hz that gives them.
    spread : how parameters differ from unit to unit; a figure that is no tolerance has none.
    compared : whether the figure was compared with the document, or with a text that quotes it.
    """

    quantity: str
    words: str
    effect: type[Effect]
    values: Values | Callable[[float], Values]
    spread: Mapping[str, Vary] = field(default_factory=dict)
    compared: bool = True

    def at(self, rate_hz: float) -> Values:
        """The effect's parameters at a sample rate, those of a unit in the middle of its tolerances."""
        return self.values(rate_hz) if callable(self.values) else self.values


@dataclass(frozen=True)
class Sensor:
    """A magnetometer by its data sheet.

    document : title and revision of the sheet. left_out : what it does not say, or what no effect models. fastest_hz :
    the greatest sample rate, None where the sheet gives none below the simulator's. scalar : it gives the field's
    strength alone.
    """

    name: str
    summary: str
    document: str
    figures: tuple[DatasheetFigure, ...]
    left_out: str
    fastest_hz: float | None = None
    scalar: bool = False

    def tables(self, rate_hz: float) -> dict[str, dict[str, Any]]:
        """The effects' tables as a scenario writes them, at a sample rate in Hz, of a unit without its tolerances."""
        found: dict[str, dict[str, Any]] = {}
        for figure in self.figures:
            found.setdefault(figure.effect.name, {}).update(figure.at(rate_hz))
        return found

    def spread(self) -> dict[tuple[str, str], Vary]:
        """(effect, parameter) -> how it differs from unit to unit."""
        return {(one.effect.name, key): how for one in self.figures for key, how in one.spread.items()}
