"""Fault of a sensor: the rows concerned, in words, and what screening did about them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.text import listed

Mask = NDArray[np.bool_]
Remedy = Literal["left out", "unwrapped", "none"]
AXES = "xyz"
MOST_STRETCHES = 3
"""Stretches of rows that are listed; more are counted."""


@dataclass(frozen=True, eq=False)
class Fault:
    """Fault of a magnetometer in `rows` (n,) of a recording.

    kind : one word for files. text : a clause, "axis z is stuck at 25,013 nT".
    remedy : "left out" of the fit; "unwrapped", with the field `mended_nT` (n, 3); "none" where the rows stay.
    doubtful : with the rows still in, no estimate can be trusted. sensor : index in an array, None for a single one.
    detail : places and sizes as plain values.
    """

    kind: str
    text: str
    rows: Mask
    remedy: Remedy = "left out"
    doubtful: bool = False
    mended_nT: Array | None = None
    sensor: int | None = None
    detail: tuple[dict[str, Any], ...] = ()

    @property
    def told(self) -> str:
        """Return fault and remedy as a clause: "rows 151 to 600 were left out: axis z is stuck at 25,013 nT"."""
        text = self.text if self.sensor is None else f"sensor {self.sensor + 1}: {self.text}"
        count = int(np.count_nonzero(self.rows))
        if self.remedy == "none" or not count:
            return text
        return f"{rows_text(self.rows)} {'was' if count == 1 else 'were'} {self.remedy}: {text}"

    def summary(self) -> dict[str, Any]:
        """Return the fault as plain values for JSON."""
        return {
            "kind": self.kind,
            "text": self.told,
            "rows": int(np.count_nonzero(self.rows)),
            "stretches": [[first + 1, last + 1] for first, last in stretches(self.rows)],
            "remedy": self.remedy,
            "doubtful": self.doubtful,
            "sensor": self.sensor,
            "detail": list(self.detail),
        }

    def among(self, kept: NDArray[np.intp], total: int) -> Fault:
        """Return the fault with rows counted in a recording of `total` rows, of which `kept` were looked at."""
        rows = np.zeros(total, np.bool_)
        rows[kept[self.rows]] = True
        return replace(self, rows=rows, mended_nT=None)


def stretches(rows: Mask) -> list[tuple[int, int]]:
    """Return first and last index of each stretch of marked rows (n,)."""
    edges = np.flatnonzero(np.diff(np.r_[False, rows, False]))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def rows_text(rows: Mask) -> str:
    """Return marked rows in words, counted from 1: "row 4", "rows 151 to 600", or a count of scattered rows."""
    found = stretches(rows)
    if len(found) > MOST_STRETCHES:
        return f"{np.count_nonzero(rows)} rows"
    parts = [str(a + 1) if a == b else f"{a + 1} to {b + 1}" for a, b in found]
    return f"row{'' if np.count_nonzero(rows) == 1 else 's'} {listed(parts)}"
