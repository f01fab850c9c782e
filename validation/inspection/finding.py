"""What an inspection says: one value, its unit and one plain sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Level = Literal["ok", "note", "warning"]


@dataclass(frozen=True)
class Finding:
    """A value (number, list, mapping or text) with its unit and a sentence; `level` says how much it matters.

    sensor : number of the sensor of an array that it is about, None for the recording as a whole.
    """

    section: str
    name: str
    value: Any
    unit: str
    text: str
    level: Level = "ok"
    sensor: int | None = None
