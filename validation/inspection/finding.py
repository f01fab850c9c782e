"""Finding of an inspection: a value, a unit and a plain sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Level = Literal["ok", "note", "warning"]


@dataclass(frozen=True)
class Finding:
    """Value (number, list, mapping or text) with a unit, a sentence, and `level` for the severity.

    sensor : number of the sensor in an array, None for the recording as a whole.
    """

    section: str
    name: str
    value: Any
    unit: str
    text: str
    level: Level = "ok"
    sensor: int | None = None
