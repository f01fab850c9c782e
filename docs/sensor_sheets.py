"""The sensors of `sensors.md`: what their data sheets say, and the effects that stand for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.sensors import SENSORS, DatasheetFigure, Sensor

SHOWN_HZ = 10.0
"""Sample rate at which the noise of a density is shown."""
HEADS = ("quantity", "data sheet", "effect")


@dataclass(frozen=True)
class Sheet:
    """A sensor's paragraph, and a row a figure under HEADS."""

    head: str
    rows: tuple[tuple[str, ...], ...]


def all_of_them() -> Iterator[Sheet]:
    """Every sensor, in the order of the table."""
    return map(_sheet, SENSORS.values())


def _sheet(sensor: Sensor) -> Sheet:
    rate = f" At most {sensor.fastest_hz:g} samples a second." if sensor.fastest_hz else ""
    head = f"**`{sensor.name}`**. {sensor.summary}.{rate} Source: {sensor.document}. Left out: {sensor.left_out}."
    rows = ((one.quantity, one.words + ("" if one.compared else " †"), _stands(one)) for one in sensor.figures)
    return Sheet(head, tuple(rows))


def _stands(figure: DatasheetFigure) -> str:
    """The effect of a figure, with the parameters that are drawn by their law."""
    laws = {key: next(iter(how.model_dump(exclude_none=True).items())) for key, how in figure.spread.items()}
    drawn = [f"`{key}` {name} {_pair(pair)}" for key, (name, pair) in laws.items()]
    fixed = [f"`{key}` {_pair(value)}" for key, value in figure.at(SHOWN_HZ).items() if key not in laws]
    return f"`{figure.effect.name}`: " + ", ".join((*drawn, *fixed))


def _pair(value: Any) -> str:
    numbers = np.atleast_1d(value)
    same = len(numbers) == 3 and len(set(numbers)) == 1
    return ", ".join(f"{number:.6g}" for number in (numbers[:1] if same else numbers))
